#pragma once
// The interpreter's lock, and long calculations of the core without it, which Ctrl-C can still end.

#include <pybind11/pybind11.h>

#include <atomic>
#include <memory>
#include <optional>
#include <thread>
#include <type_traits>
#include <utility>

#include "cogging/interruption.hpp"

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

/// A reference that may be given back by a thread without the interpreter's lock.
class Kept {
 public:
  explicit Kept(pybind11::object object) : object_(std::move(object)) {}
  Kept(const Kept&) = delete;
  Kept& operator=(const Kept&) = delete;
  ~Kept() {
    if (!Py_IsInitialized()) {
      object_.release();
      return;
    }
    const GilTaken taken;
    object_ = pybind11::object();
  }
  const pybind11::object& object() const { return object_; }

 private:
  pybind11::object object_;
};

/// Calls a function that may be written in Python, which gives up the lock now and then.
inline pybind11::object called(const pybind11::handle& function, const pybind11::tuple& given = pybind11::tuple()) {
  PyObject* result = or_wait_for_ever([&] { return PyObject_CallObject(function.ptr(), given.ptr()); });
  if (result == nullptr) throw pybind11::error_already_set();
  return pybind11::reinterpret_steal<pybind11::object>(result);
}

/// Set by one thread to end what others, which heed it, do in the core.
class StopFlag {
 public:
  void set() { stopped_->store(true, std::memory_order_relaxed); }
  void heed() const { heeded() = stopped_; }

  /// Of the calling thread; none at first.
  static std::shared_ptr<std::atomic<bool>>& heeded() {
    static thread_local std::shared_ptr<std::atomic<bool>> flag;
    return flag;
  }

 private:
  std::shared_ptr<std::atomic<bool>> stopped_ = std::make_shared<std::atomic<bool>>(false);
};

/// Python's signals, as a stop request: the thread that called, where it is Python's main thread, lets Python run its
/// handlers every 50 ms; what one of them raises ends the work on all threads. In any thread, the flag that it heeds.
class PythonSignals final : public cogging::StopRequest {
  using Clock = std::chrono::steady_clock;

 public:
  static inline unsigned long main_thread = 0;  // Python's; set when the module is imported

  PythonSignals() : caller_(PyThread_get_thread_ident()), heeded_(StopFlag::heeded()), next_(Clock::now() + period) {}

  bool requested(Clock::time_point now) override {
    if (stopped_.load(std::memory_order_relaxed)) return true;
    if (heeded_ && heeded_->load(std::memory_order_relaxed)) return true;
    // Other threads run no handlers; and one of them may be waiting for the lock for ever once Python has ended.
    if (caller_ != main_thread || PyThread_get_thread_ident() != caller_ || now < next_) return false;
    const GilTaken taken;
    const bool raised = PyErr_CheckSignals() != 0;
    if (raised) raised_.emplace();
    next_ = Clock::now() + period;
    stopped_.store(raised, std::memory_order_relaxed);
    return raised;
  }

  /// Ends the work on all threads with an exception that ends whatever raises it: KeyboardInterrupt, SystemExit. With
  /// the lock held.
  void end_with(const pybind11::error_already_set& error) {
    if (!raised_) raised_.emplace(error);
    stopped_.store(true, std::memory_order_relaxed);
  }

  /// Throws what the handler raised, or KeyboardInterrupt where the flag was set; with the lock held.
  [[noreturn]] void raise() {
    if (raised_) throw *raised_;
    PyErr_SetNone(PyExc_KeyboardInterrupt);
    throw pybind11::error_already_set();
  }

 private:
  static constexpr std::chrono::milliseconds period{50};
  unsigned long caller_;
  std::shared_ptr<std::atomic<bool>> heeded_;
  Clock::time_point next_;
  std::atomic<bool> stopped_{false};
  std::optional<pybind11::error_already_set> raised_;
};

/// Runs work(stop request) without the lock, and raises what Python's signal handlers raised meanwhile.
template <class Work>
std::invoke_result_t<const Work&, cogging::StopRequest*> without_gil(const Work& work) {
  PythonSignals signals;
  try {
    const GilReleased released;
    return work(static_cast<cogging::StopRequest*>(&signals));
  } catch (const cogging::Interrupted&) {
    signals.raise();
  }
}

/// Lets Python's other threads have the lock for a moment whenever a loop that holds it asks whether to end.
class GivesTurns final : public cogging::StopRequest {
 public:
  explicit GivesTurns(cogging::StopRequest& request) : request_(request) {}

  bool requested(std::chrono::steady_clock::time_point now) override {
    const GilReleased released;
    return request_.requested(now);
  }

 private:
  cogging::StopRequest& request_;
};

/// Inside without_gil, on any of its threads: runs work(stop request) that calls Python throughout, with the lock. A
/// KeyboardInterrupt out of it, as all that is no Exception, ends the work on all threads.
template <class Work>
auto with_gil(cogging::StopRequest* signals, const Work& work) {
  const GilTaken taken;
  GivesTurns turns(*signals);
  try {
    return work(static_cast<cogging::StopRequest*>(&turns));
  } catch (const pybind11::error_already_set& error) {
    if (error.matches(PyExc_Exception)) throw;
    static_cast<PythonSignals*>(signals)->end_with(error);
    throw cogging::Interrupted();
  }
}
