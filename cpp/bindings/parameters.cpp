#include "bindings.hpp"

namespace {

// Where the data lie of a struct that Python holds; refuses what is none.
const char* data_of(const py::handle& self, const py::detail::type_info* type) {
  py::detail::type_caster_generic caster(type);
  if (!caster.load(self, false) || caster.value == nullptr) throw py::type_error("incompatible function arguments");
  return static_cast<const char*>(caster.value);
}

py::dict values_of(const BoundStruct& bound, const char* place) {
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

void bind_fields(const py::object& type, const BoundStruct& all) {
  const auto bound = std::make_shared<const BoundStruct>(all);
  const auto* info = py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(type.ptr()));
  const std::string name =
      type.attr("__module__").cast<std::string>() + "." + type.attr("__qualname__").cast<std::string>();
  py::options options;
  options.disable_function_signatures();  // they stand in the docs here, since the functions do not know the types
  const auto method = [&](const char* called, const std::string& signature, auto function, const auto&... extra) {
    py::setattr(
        type, called,
        py::cpp_function(function, py::name(called), py::is_method(type), (called + signature).c_str(), extra...));
  };

  std::string signature = "(self: " + name;
  py::dict described;
  const py::object property = py::module_::import("builtins").attr("property");
  for (const BoundField& field : bound->fields) {
    signature += (described.empty() ? ", *, " : ", ") + field.name + ": " + field.given + " = " +
                 py::repr(field.usual).cast<std::string>();
    described[py::str(field.name)] = py::make_tuple(field.unit, field.meaning);
    const py::cpp_function read(
        [bound, info, &field](const py::object& self) { return field.get(data_of(self, info) + field.offset); },
        ("(self: " + name + ") -> " + field.kept).c_str());
    const std::string text = field.meaning + (field.unit.empty() ? "" : ", " + field.unit);
    py::setattr(type, field.name.c_str(), property(read, py::none(), py::none(), text));
  }
  type.attr("FIELDS") = described;
  method(
      "__init__", signature + ") -> None\n",
      [bound](py::detail::value_and_holder& self, const py::kwargs& given) {
        self.value_ptr() = bound->make([&](void* place) { fill(*bound, static_cast<char*>(place), given); });
      },
      py::detail::is_new_style_constructor());
  method("to_dict", "(self: " + name + ") -> dict\n\nAll fields by name.\n",
         [bound, info](const py::object& self) { return values_of(*bound, data_of(self, info)); });
  method("replace", "(self: " + name + ", **kwargs) -> " + name + "\n\nA copy with the given fields changed.\n",
         [bound, info](const py::object& self, const py::kwargs& changes) {
           py::dict values = values_of(*bound, data_of(self, info));
           for (const auto& change : changes) values[change.first] = change.second;
           return py::type::of(self)(**values);
         });
}
