// The unit as FMI 3.0 has it, for co-simulation: what its importer calls.

#include <exception>
#include <memory>
#include <string_view>

#include "axis_unit.hpp"
#include "fmi3.hpp"
#include "resource.hpp"

namespace cogging::fmi {

namespace {

/// Value references that every unit has; those of the parameters but the seed stand in its resource.
enum Variable : fmi3ValueReference {
  time_variable,
  command_variable,
  reading_variable,
  position_variable,
  velocity_variable,
  seed_variable
};

/// What the interface allows when.
enum class Phase { instantiated, initialization, stepping, terminated, failed };

/// All that a unit is in, besides what it is made of: what an importer may keep and give back.
struct Situation : Machine {
  Phase phase = Phase::instantiated;
  double start_time = 0.0, command = 0.0;  // s, V
  std::optional<AxisUnit> axis = {};       // made where it is first asked for

  AxisUnit& made() {
    if (!axis) axis.emplace(plant, start);
    return *axis;
  }
};

struct Instance {
  Resource resource;
  std::string name;
  fmi3InstanceEnvironment environment = nullptr;
  fmi3LogMessageCallback log = nullptr;
  Situation now;

  fmi3Status refuse(const std::string& line) const {
    if (log != nullptr) log(environment, fmi3Error, "logStatusError", (name + ": " + line).c_str());
    return fmi3Error;
  }
};

Instance* instance_of(fmi3Instance instance) {
  return static_cast<Instance*>(instance);
}

/// Runs what a function of the interface does: whatever it throws is told and becomes an error.
template <class Body>
fmi3Status answer(fmi3Instance instance, const Body& body) {
  Instance* const unit = instance_of(instance);
  if (unit == nullptr) return fmi3Error;
  try {
    return body(*unit);
  } catch (const std::exception& error) {
    return unit->refuse(error.what());
  } catch (...) {
    return unit->refuse("failed for no stated reason");
  }
}

/// The same from one phase into another.
template <class Body>
fmi3Status enter(fmi3Instance instance, Phase from, Phase to, std::string_view rule, const Body& body) {
  return answer(instance, [&](Instance& unit) {
    if (unit.now.phase != from) return unit.refuse(std::string(rule));
    try {
      body(unit);
    } catch (...) {
      unit.now.phase = Phase::failed;
      throw;
    }
    unit.now.phase = to;
    return fmi3OK;
  });
}

double* parameter_of(Instance& unit, fmi3ValueReference reference) {
  const auto place = unit.resource.parameters.find(reference);
  return place == unit.resource.parameters.end() ? nullptr : find_parameter(unit.now, place->second);
}

/// The value of a variable. Raises std::invalid_argument where there is none of this reference.
double value_of(Instance& unit, fmi3ValueReference reference) {
  Situation& now = unit.now;
  switch (reference) {
    case time_variable:
      return now.start_time + (now.axis ? now.axis->time() : 0.0);
    case command_variable:
      return now.command;
    case reading_variable:
      return now.made().reading();
    case position_variable:
      return now.made().position();
    case velocity_variable:
      return now.made().velocity();
    default:
      break;
  }
  const double* const parameter = parameter_of(unit, reference);
  if (parameter == nullptr) refuse("value reference", "must be that of a Float64", format(reference));
  return *parameter;
}

/// A parameter stays what it is once the unit steps.
template <class Value>
void set_parameter(Instance& unit, Value* parameter, fmi3ValueReference reference, Value value) {
  if (parameter == nullptr) refuse("value reference", "must be that of an input or a parameter", format(reference));
  if (unit.now.phase != Phase::instantiated && unit.now.phase != Phase::initialization)
    refuse("value reference", "must not be that of a fixed parameter after initialization", format(reference));
  *parameter = value;
  unit.now.axis.reset();
}

/// Calls each(unit, reference, value) for every variable that is read or written.
template <class Value, class Each>
fmi3Status for_each_variable(fmi3Instance instance, const fmi3ValueReference* references, std::size_t count,
                             Value* values, std::size_t value_count, const Each& each) {
  return answer(instance, [&](Instance& unit) {
    require(count == value_count, "nValues", "must be nValueReferences", value_count);
    for (std::size_t i = 0; i < count; ++i) each(unit, references[i], values[i]);
    return fmi3OK;
  });
}

/// Moves on by a step; the phase is that of a failure where it cannot.
fmi3Status step(Instance& unit, double from, double length) {
  Situation& now = unit.now;
  if (now.phase != Phase::stepping) return unit.refuse("fmi3DoStep: must be called between initialization and end");
  AxisUnit& axis = now.made();
  const double begin = from - now.start_time, slack = 1e-3 / now.start.sample_rate;
  if (!(std::abs(axis.snapped(begin) - axis.time()) <= slack))
    return unit.refuse("fmi3DoStep: currentCommunicationPoint: must be the time that is reached, " +
                       format(now.start_time + axis.time()) + " s, got " + format(from));
  if (!(length > 0.0 && std::isfinite(length)))
    return unit.refuse("fmi3DoStep: communicationStepSize: must be finite and above 0, got " + format(length));
  try {
    axis.advance(begin + length, now.command);
  } catch (...) {
    now.phase = Phase::failed;
    throw;
  }
  return fmi3OK;
}

}  // namespace

}  // namespace cogging::fmi

using namespace cogging::fmi;

COGGING_FMI const char* fmi3GetVersion() {
  return "3.0";
}

COGGING_FMI fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean, std::size_t, const fmi3String*) {
  return answer(instance, [](Instance&) { return fmi3OK; });  // errors are told in any case, and there is nothing else
}

COGGING_FMI fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                                     fmi3Boolean, fmi3Boolean, fmi3Boolean event_mode, fmi3Boolean,
                                                     const fmi3ValueReference*, std::size_t intermediate,
                                                     fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                                     fmi3IntermediateUpdateCallback) {
  auto unit = std::make_unique<Instance>();
  unit->name = name == nullptr ? "" : name;
  unit->environment = environment;
  unit->log = log;
  const fmi3Status status = answer(unit.get(), [&](Instance& made) {
    if (event_mode || intermediate > 0) return made.refuse("has neither an event mode nor intermediate variables");
    if (token == nullptr || resources == nullptr) return made.refuse("must be given a token and a resource path");
    std::string folder = resources;
    if (!folder.ends_with('/') && !folder.ends_with('\\')) folder += '/';
    made.resource = read_resource(folder + "axis.txt");
    if (made.resource.token != token)
      return made.refuse("instantiationToken: must be " + made.resource.token + ", got " + token);
    made.now = Situation{made.resource};
    return fmi3OK;
  });
  return status == fmi3OK ? unit.release() : nullptr;
}

COGGING_FMI void fmi3FreeInstance(fmi3Instance instance) {
  delete instance_of(instance);
}

COGGING_FMI fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean, fmi3Float64,
                                                   fmi3Float64 start_time, fmi3Boolean, fmi3Float64) {
  return enter(instance, Phase::instantiated, Phase::initialization,
               "fmi3EnterInitializationMode: must be called first, once", [&](Instance& unit) {
                 cogging::require_finite("startTime", start_time);
                 unit.now.start_time = start_time;
               });
}

COGGING_FMI fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
  return enter(instance, Phase::initialization, Phase::stepping,
               "fmi3ExitInitializationMode: must be called in initialization", [](Instance& unit) { unit.now.made(); });
}

COGGING_FMI fmi3Status fmi3Terminate(fmi3Instance instance) {
  return enter(instance, Phase::stepping, Phase::terminated, "fmi3Terminate: must be called behind initialization",
               [](Instance&) {});
}

COGGING_FMI fmi3Status fmi3Reset(fmi3Instance instance) {
  return answer(instance, [](Instance& unit) {
    unit.now = Situation{unit.resource};
    return fmi3OK;
  });
}

COGGING_FMI fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 from, fmi3Float64 length, fmi3Boolean,
                                  fmi3Boolean* event, fmi3Boolean* terminate, fmi3Boolean* early_return,
                                  fmi3Float64* last_time) {
  for (fmi3Boolean* flag : {event, terminate, early_return})
    if (flag != nullptr) *flag = false;
  const fmi3Status status = answer(instance, [&](Instance& unit) { return step(unit, from, length); });
  if (instance != nullptr && last_time != nullptr) *last_time = value_of(*instance_of(instance), time_variable);
  return status;
}

COGGING_FMI fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference* references, std::size_t count,
                                      fmi3Float64* values, std::size_t value_count) {
  return for_each_variable(
      instance, references, count, values, value_count,
      [](Instance& unit, fmi3ValueReference reference, fmi3Float64& value) { value = value_of(unit, reference); });
}

COGGING_FMI fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference* references, std::size_t count,
                                      const fmi3Float64* values, std::size_t value_count) {
  return for_each_variable(instance, references, count, values, value_count,
                           [](Instance& unit, fmi3ValueReference reference, fmi3Float64 value) {
                             if (reference == command_variable)
                               unit.now.command = value;
                             else
                               set_parameter(unit, parameter_of(unit, reference), reference, value);
                           });
}

COGGING_FMI fmi3Status fmi3GetUInt64(fmi3Instance instance, const fmi3ValueReference* references, std::size_t count,
                                     fmi3UInt64* values, std::size_t value_count) {
  return for_each_variable(instance, references, count, values, value_count,
                           [](Instance& unit, fmi3ValueReference reference, fmi3UInt64& value) {
                             cogging::require(reference == seed_variable, "value reference", "must be that of the seed",
                                              reference);
                             value = unit.now.start.seed;
                           });
}

COGGING_FMI fmi3Status fmi3SetUInt64(fmi3Instance instance, const fmi3ValueReference* references, std::size_t count,
                                     const fmi3UInt64* values, std::size_t value_count) {
  return for_each_variable(instance, references, count, values, value_count,
                           [](Instance& unit, fmi3ValueReference reference, fmi3UInt64 value) {
                             std::uint64_t* const seed = reference == seed_variable ? &unit.now.start.seed : nullptr;
                             set_parameter<std::uint64_t>(unit, seed, reference, value);
                           });
}

COGGING_FMI fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState* state) {
  return answer(instance, [&](Instance& unit) {
    if (*state == nullptr)
      *state = new Situation(unit.now);
    else
      *static_cast<Situation*>(*state) = unit.now;
    return fmi3OK;
  });
}

COGGING_FMI fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
  return answer(instance, [&](Instance& unit) {
    if (state == nullptr) return unit.refuse("fmi3SetFMUState: must be given a state");
    unit.now = *static_cast<const Situation*>(state);
    return fmi3OK;
  });
}

COGGING_FMI fmi3Status fmi3FreeFMUState(fmi3Instance, fmi3FMUState* state) {
  if (state == nullptr) return fmi3OK;
  delete static_cast<Situation*>(*state);
  *state = nullptr;
  return fmi3OK;
}

/// Of not_supported.cpp: says that this unit has no such function, which is an error.
fmi3Status refuse_function(fmi3Instance instance, const char* name) {
  return answer(instance, [&](Instance& unit) {
    return unit.refuse(std::string(name) + ": is not offered by this unit (see the capabilities in its description)");
  });
}
