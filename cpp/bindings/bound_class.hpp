#pragma once
// Methods that are compiled once for all classes: they know nothing of a type but where the data of an object lie.

#include "bindings.hpp"

/// The object whose method is called. One that is not initialised is refused before the other arguments are looked at.
struct Self {
  py::handle object;
  const py::detail::type_info* type = nullptr;
  void* data = nullptr;
};

template <>
struct pybind11::detail::type_caster<Self> {
  PYBIND11_TYPE_CASTER(Self, const_name("object"));

  bool load(handle source, bool) {
    const auto& types = all_type_info(Py_TYPE(source.ptr()));
    if (types.size() != 1) return false;
    type_caster_generic caster(types.front());
    if (!caster.load(source, false)) return false;
    value = {source, types.front(), caster.value};
    return value.data != nullptr;
  }
};

template <class Object>
const Object& object_at(const void* data) {
  return *static_cast<const Object*>(data);
}

class BoundClass {
 public:
  explicit BoundClass(const py::object& type);

  /// As signatures show it: cogging._core.Pid.
  const std::string& name() const { return name_; }
  /// Raises TypeError for an object of another class.
  void* data_of(const Self& self) const;

  /// Adds a method; the signature is what stands behind `self` in help().
  template <class Function, class... Extra>
  void def(const char* method, const std::string& signature, const std::string& doc, const Function& function,
           const Extra&... extra) const {
    const std::string text = method + ("(self: " + name_ + signature) + "\n" + (doc.empty() ? "" : "\n" + doc + "\n");
    def_documented(method, text, function, extra...);
  }
  template <class Function, class... Extra>
  void def_documented(const char* method, const std::string& text, const Function& function,
                      const Extra&... extra) const {
    py::options options;
    options.disable_function_signatures();  // the functions do not know the types
    py::setattr(type_, method,
                py::cpp_function(function, py::name(method), py::is_method(type_),
                                 py::sibling(py::getattr(type_, method, py::none())), text.c_str(), extra...));
  }
  /// Adds a property, read by get(data) and of the type that is named.
  void def_property(const char* property, const std::string& kind, const std::string& doc,
                    const std::function<py::object(const void*)>& get) const;

 private:
  py::handle type_;
  const py::detail::type_info* info_;
  std::string name_;
};
