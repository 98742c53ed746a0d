// The functions of FMI 3.0 that a unit must have and this one does not offer: other types of variables, other kinds of
// simulation, what needs derivatives or clocks. Asked for nothing, they do nothing; else it is an error that is told.

#include "fmi3.hpp"

fmi3Status refuse_function(fmi3Instance instance, const char* name);

COGGING_FMI fmi3Instance fmi3InstantiateModelExchange(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                                      fmi3InstanceEnvironment, fmi3LogMessageCallback) {
  return nullptr;
}

COGGING_FMI fmi3Instance fmi3InstantiateScheduledExecution(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                                           fmi3InstanceEnvironment, fmi3LogMessageCallback,
                                                           fmi3ClockUpdateCallback, fmi3LockPreemptionCallback,
                                                           fmi3UnlockPreemptionCallback) {
  return nullptr;
}

// What reads or writes `count` values of a type.
#define COGGING_OF_VALUES(name, ...)                                                                              \
  COGGING_FMI fmi3Status name(fmi3Instance instance, const fmi3ValueReference*, std::size_t count, __VA_ARGS__) { \
    return count == 0 ? fmi3OK : refuse_function(instance, #name);                                                \
  }
// Both of a type.
#define COGGING_OF_TYPE(type)                                \
  COGGING_OF_VALUES(fmi3Get##type, fmi3##type*, std::size_t) \
  COGGING_OF_VALUES(fmi3Set##type, const fmi3##type*, std::size_t)
// What does anything else.
#define COGGING_REFUSED(name, ...)                                                \
  COGGING_FMI fmi3Status name(fmi3Instance instance __VA_OPT__(, ) __VA_ARGS__) { \
    return refuse_function(instance, #name);                                      \
  }

COGGING_OF_TYPE(Float32)
COGGING_OF_TYPE(Int8)
COGGING_OF_TYPE(UInt8)
COGGING_OF_TYPE(Int16)
COGGING_OF_TYPE(UInt16)
COGGING_OF_TYPE(Int32)
COGGING_OF_TYPE(UInt32)
COGGING_OF_TYPE(Int64)
COGGING_OF_TYPE(Boolean)
COGGING_OF_TYPE(String)
COGGING_OF_VALUES(fmi3GetBinary, std::size_t*, fmi3Binary*, std::size_t)
COGGING_OF_VALUES(fmi3SetBinary, const std::size_t*, const fmi3Binary*, std::size_t)
COGGING_OF_VALUES(fmi3GetClock, fmi3Clock*)
COGGING_OF_VALUES(fmi3SetClock, const fmi3Clock*)
COGGING_OF_VALUES(fmi3GetIntervalDecimal, fmi3Float64*, fmi3IntervalQualifier*)
COGGING_OF_VALUES(fmi3GetIntervalFraction, fmi3UInt64*, fmi3UInt64*, fmi3IntervalQualifier*)
COGGING_OF_VALUES(fmi3GetShiftDecimal, fmi3Float64*)
COGGING_OF_VALUES(fmi3GetShiftFraction, fmi3UInt64*, fmi3UInt64*)
COGGING_OF_VALUES(fmi3SetIntervalDecimal, const fmi3Float64*)
COGGING_OF_VALUES(fmi3SetIntervalFraction, const fmi3UInt64*, const fmi3UInt64*)
COGGING_OF_VALUES(fmi3SetShiftDecimal, const fmi3Float64*)
COGGING_OF_VALUES(fmi3SetShiftFraction, const fmi3UInt64*, const fmi3UInt64*)
COGGING_OF_VALUES(fmi3GetOutputDerivatives, const fmi3Int32*, fmi3Float64*, std::size_t)

COGGING_REFUSED(fmi3EnterEventMode)
COGGING_REFUSED(fmi3EnterStepMode)
COGGING_REFUSED(fmi3EnterConfigurationMode)
COGGING_REFUSED(fmi3ExitConfigurationMode)
COGGING_REFUSED(fmi3EvaluateDiscreteStates)
COGGING_REFUSED(fmi3UpdateDiscreteStates, fmi3Boolean*, fmi3Boolean*, fmi3Boolean*, fmi3Boolean*, fmi3Boolean*,
                fmi3Float64*)
COGGING_REFUSED(fmi3GetNumberOfVariableDependencies, fmi3ValueReference, std::size_t*)
COGGING_REFUSED(fmi3GetVariableDependencies, fmi3ValueReference, std::size_t*, fmi3ValueReference*, std::size_t*,
                fmi3DependencyKind*, std::size_t)
COGGING_REFUSED(fmi3SerializedFMUStateSize, fmi3FMUState, std::size_t*)
COGGING_REFUSED(fmi3SerializeFMUState, fmi3FMUState, fmi3Byte*, std::size_t)
COGGING_REFUSED(fmi3DeserializeFMUState, const fmi3Byte*, std::size_t, fmi3FMUState*)
COGGING_REFUSED(fmi3GetDirectionalDerivative, const fmi3ValueReference*, std::size_t, const fmi3ValueReference*,
                std::size_t, const fmi3Float64*, std::size_t, fmi3Float64*, std::size_t)
COGGING_REFUSED(fmi3GetAdjointDerivative, const fmi3ValueReference*, std::size_t, const fmi3ValueReference*,
                std::size_t, const fmi3Float64*, std::size_t, fmi3Float64*, std::size_t)

// Model exchange and scheduled execution.
COGGING_REFUSED(fmi3EnterContinuousTimeMode)
COGGING_REFUSED(fmi3CompletedIntegratorStep, fmi3Boolean, fmi3Boolean*, fmi3Boolean*)
COGGING_REFUSED(fmi3SetTime, fmi3Float64)
COGGING_REFUSED(fmi3SetContinuousStates, const fmi3Float64*, std::size_t)
COGGING_REFUSED(fmi3GetContinuousStateDerivatives, fmi3Float64*, std::size_t)
COGGING_REFUSED(fmi3GetEventIndicators, fmi3Float64*, std::size_t)
COGGING_REFUSED(fmi3GetContinuousStates, fmi3Float64*, std::size_t)
COGGING_REFUSED(fmi3GetNominalsOfContinuousStates, fmi3Float64*, std::size_t)
COGGING_REFUSED(fmi3GetNumberOfEventIndicators, std::size_t*)
COGGING_REFUSED(fmi3GetNumberOfContinuousStates, std::size_t*)
COGGING_REFUSED(fmi3ActivateModelPartition, fmi3ValueReference, fmi3Float64)
