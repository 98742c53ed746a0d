#include "bound_class.hpp"

namespace {

py::dict values_of(const BoundStruct& bound, const void* data) {
  const char* const place = static_cast<const char*>(data);
  py::dict values;
  for (const BoundField& field : bound.fields) values[py::str(field.name)] = field.get(place + field.offset);
  return values;
}

// Writes what is given; a name or a value that does not fit ends as any call that no signature takes (module.cpp).
void fill(const BoundStruct& bound, char* place, const py::kwargs& given) {
  std::size_t known = 0;
  for (const BoundField& field : bound.fields) {
    if (!given.contains(field.name)) continue;
    ++known;
    try {
      field.set(place + field.offset, field.name, given[field.name.c_str()]);
    } catch (const py::cast_error&) {
      throw py::type_error("__init__(): incompatible constructor arguments: " + field.name);
    }
  }
  if (known < given.size()) throw py::type_error("__init__(): incompatible constructor arguments: an unknown name");
}

}  // namespace

std::string doc_of(const std::string& doc, const BoundStruct& bound) {
  std::string text = doc + "\n\nFields:\n";
  for (const BoundField& field : bound.fields) {
    text += "    " + field.name;
    if (!field.unit.empty() && field.unit != "1") text += " (" + field.unit + ")";
    text += ": " + field.meaning + "\n";
  }
  return text + "\nRaises:\n    ValueError: a value breaks its rule; the message names field, rule and value.";
}

BoundClass::BoundClass(const py::object& type)
    : type_(type),
      info_(py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(type.ptr()))),
      name_(type.attr("__module__").cast<std::string>() + "." + type.attr("__qualname__").cast<std::string>()) {}

void* BoundClass::data_of(const Self& self) const {
  if (self.type != info_)
    throw py::type_error("self: must be a " + name_ + ", got a " + Py_TYPE(self.object.ptr())->tp_name);
  return self.data;
}

void BoundClass::def_property(const char* property, const std::string& kind, const std::string& doc,
                              const std::function<py::object(const void*)>& get) const {
  py::options options;
  options.disable_function_signatures();
  const py::cpp_function read([bound = *this, get](const Self& self) { return get(bound.data_of(self)); },
                              ("(self: " + name_ + ") -> " + kind).c_str());
  py::setattr(type_, property, py::module_::import("builtins").attr("property")(read, py::none(), py::none(), doc));
}

void bind_fields(const py::object& type, const BoundStruct& all) {
  const auto bound = std::make_shared<const BoundStruct>(all);
  const BoundClass self_class(type);
  std::string signature;
  py::dict described;
  for (const BoundField& field : bound->fields) {
    signature += (described.empty() ? ", *, " : ", ") + field.name + ": " + field.given + " = " +
                 py::repr(field.usual).cast<std::string>();
    described[py::str(field.name)] = py::make_tuple(field.unit, field.meaning);
    const std::string text = field.meaning + (field.unit.empty() ? "" : ", " + field.unit);
    self_class.def_property(field.name.c_str(), field.kept, text, [bound, &field](const void* data) {
      return field.get(static_cast<const char*>(data) + field.offset);
    });
  }
  type.attr("FIELDS") = described;
  self_class.def(
      "__init__", signature + ") -> None", "",
      [bound](py::detail::value_and_holder& self, const py::kwargs& given) {
        self.value_ptr() = bound->make([&](void* place) { fill(*bound, static_cast<char*>(place), given); });
      },
      py::detail::is_new_style_constructor());
  self_class.def("to_dict", ") -> dict", "All fields by name.",
                 [bound, self_class](const Self& self) { return values_of(*bound, self_class.data_of(self)); });
  self_class.def("replace", ", **kwargs) -> " + self_class.name(), "A copy with the given fields changed.",
                 [bound, self_class](const Self& self, const py::kwargs& changes) {
                   py::dict values = values_of(*bound, self_class.data_of(self));
                   for (const auto& change : changes) values[change.first] = change.second;
                   return py::type::of(self.object)(**values);
                 });
}

void enlist(py::module_& module, const char* part, py::dict& list, std::string_view name, const py::object& bound,
            const py::object& parameters) {
  const py::module_ names = module.attr(part);
  const auto add = [&](const py::object& one) {
    const py::object called = one.attr("__name__");
    if (!py::hasattr(names, called)) names.attr("__all__").attr("append")(called);
    py::setattr(names, called, one);
  };
  bound.attr("NAME") = std::string(name);
  add(bound);
  if (!parameters.is_none()) {
    bound.attr("PARAMETERS") = parameters;
    add(parameters);
  }
  list[py::str(std::string(name))] = bound;
}
