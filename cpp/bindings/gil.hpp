#pragma once
// The interpreter's lock, also where Python ends while a thread waits for it.

#include <pybind11/pybind11.h>

#include <chrono>
#include <thread>

/// Gives call(), in which a thread may wait for the lock. Up to Python 3.13 a daemon thread that waits there when
/// Python ends is unwound by pthread_exit: objects would be destroyed without the lock, and a destructor on the way
/// would abort the process. As from Python 3.14 on, it waits for ever instead. The call is of Python's C interface and
/// leaves nothing to destroy.
template <class Call>
auto or_wait_for_ever(const Call& call) {
  struct Unwound {  // no catch: where another exception is being handled, that would abort as well
    bool returned = false;
    ~Unwound() {
      while (!returned) std::this_thread::sleep_for(std::chrono::hours(1));
    }
  } unwound;
  const auto given = call();
  unwound.returned = true;
  return given;
}

/// Holds the lock while it lives, on any thread.
class GilTaken {
 public:
  GilTaken() : state_(or_wait_for_ever(PyGILState_Ensure)) {}
  GilTaken(const GilTaken&) = delete;
  GilTaken& operator=(const GilTaken&) = delete;
  ~GilTaken() { PyGILState_Release(state_); }

 private:
  PyGILState_STATE state_;
};

/// Leaves the lock to others while it lives.
class GilReleased {
 public:
  GilReleased() : state_(PyEval_SaveThread()) {}
  GilReleased(const GilReleased&) = delete;
  GilReleased& operator=(const GilReleased&) = delete;
  ~GilReleased() {
    or_wait_for_ever([this] { return PyEval_RestoreThread(state_), 0; });
  }

 private:
  PyThreadState* state_;
};

/// Calls a function that may be written in Python, which gives up the lock now and then.
inline pybind11::object called(const pybind11::handle& function, const pybind11::tuple& given = pybind11::tuple()) {
  PyObject* result = or_wait_for_ever([&] { return PyObject_CallObject(function.ptr(), given.ptr()); });
  if (result == nullptr) throw pybind11::error_already_set();
  return pybind11::reinterpret_steal<pybind11::object>(result);
}
