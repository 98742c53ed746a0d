// Closed-loop runs that Python has made, made again from the same parameters: to the bit. `runs FILE`, written by
// test_runs.py, one item a line; a run begins with `run` and the controller's name and ends with `end`.

#include <array>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "check.hpp"
#include "cogging/control/adaptive_robust.hpp"
#include "cogging/control/cascade.hpp"
#include "cogging/control/observer_based.hpp"
#include "cogging/control/output_feedback_adaptive_robust.hpp"
#include "cogging/control/pid.hpp"
#include "cogging/control/speed.hpp"
#include "cogging/reference/point_to_point.hpp"
#include "cogging/simulation/closed_loop.hpp"

namespace {

using namespace cogging;
using Words = std::istringstream;

// Numbers come as hexadecimal ones, which the streams do not read.
bool read(Words& words, double& value) {
  std::string word;
  if (!(words >> word)) return false;
  value = std::strtod(word.c_str(), nullptr);
  return true;
}
template <class Value>
bool read(Words& words, Value& value) {
  return static_cast<bool>(words >> value);
}
template <class Value>
bool read(Words& words, std::vector<Value>& values) {
  values.clear();
  for (Value value; read(words, value);) values.push_back(value);
  return true;
}
template <class Value, std::size_t count>
bool read(Words& words, std::array<Value, count>& values) {
  for (Value& value : values)
    if (!read(words, value)) return false;
  return true;
}

template <class Struct>
void set_field(Struct& parameters, Words& words) {
  std::string name;
  words >> name;
  bool found = false;
  for_each_field<Struct>([&](const auto& field) {
    if (field.name == name) found = read(words, parameters.*(field.member));
  });
  check::holds(found, "no field " + name + ", or no value of it");
}

using AnyParameters = std::variant<PidParameters<>, CascadeParameters<>, SpeedParameters<>, AdaptiveRobustParameters<>,
                                   OutputFeedbackArcParameters<>, ObserverBasedParameters<>>;

AnyParameters parameters_named(const std::string& name) {
  if (name == "pid") return PidParameters<>{};
  if (name == "cascade") return CascadeParameters<>{};
  if (name == "speed") return SpeedParameters<>{};
  if (name == "arc" || name == "dcarc") return AdaptiveRobustParameters<>{};
  if (name == "output_feedback_arc") return OutputFeedbackArcParameters<>{};
  if (name == "observer_based") return ObserverBasedParameters<>{};
  throw std::runtime_error("no controller " + name);
}

template <class... E>
Effect<> effect_named(const std::string& name, const std::variant<E...>*) {
  std::vector<Effect<>> found;
  ((E::name == name ? found.push_back(E{}) : void()), ...);
  if (found.empty()) throw std::runtime_error("no effect " + name);
  return found.front();
}

struct Run {
  std::string name;
  AnyParameters controller;
  Plant<> plant;
  PointToPointParameters motion;
  RunOptions options;
  std::vector<double> position, command;  // what Python has found

  void take(const std::string& item, Words& words) {
    if (item == "axis") set_field(plant.axis, words);
    if (item == "encoder") set_field(plant.encoder, words);
    if (item == "noise") set_field(plant.noise, words);
    if (item == "reference") set_field(motion, words);
    if (item == "controller") std::visit([&](auto& parameters) { set_field(parameters, words); }, controller);
    if (item == "cogging") take_cogging(words);
    if (item == "effect") {
      words >> item_name;
      plant.effects.push_back(effect_named(item_name, static_cast<const Effect<>*>(nullptr)));
    }
    if (item == "effect_field")
      std::visit(
          [&]<class E>(E& law) {
            if constexpr (requires { E::fields(); }) set_field(law, words);
          },
          plant.effects.back());
    if (item == "seed") words >> options.seed;
    if (item == "position") read(words, position);
    if (item == "command") read(words, command);
  }

  // Pitch and control points; harmonics 1, 2, 3; the coefficients.
  void take_cogging(Words& words) {
    double pitch = 0.0;
    int points = 0;
    std::vector<double> coefficients;
    read(words, pitch);
    read(words, points);
    read(words, coefficients);
    plant.cogging = CoggingModel<>(SplineHarmonics::of_harmonics(pitch, {1, 2, 3}, BSpline(3, 0.0, pitch, points)),
                                   std::move(coefficients));
  }

  template <class C>
  Log<> made_with(const C& made) const {
    return closed_loop<double>(plant, made, PointToPoint(motion), options);
  }

  Log<> made() const {
    if (const auto* q = std::get_if<PidParameters<>>(&controller)) return made_with(Pid<>(*q));
    if (const auto* q = std::get_if<CascadeParameters<>>(&controller)) return made_with(Cascade<>(*q));
    if (const auto* q = std::get_if<SpeedParameters<>>(&controller)) return made_with(Speed<>(*q));
    if (const auto* q = std::get_if<AdaptiveRobustParameters<>>(&controller))
      return name == "arc" ? made_with(Arc<>(*q)) : made_with(Dcarc<>(*q));
    if (const auto* q = std::get_if<OutputFeedbackArcParameters<>>(&controller))
      return made_with(OutputFeedbackArc<>(*q));
    return made_with(ObserverBased<>(std::get<ObserverBasedParameters<>>(controller)));
  }

  void judge() const {
    const Log<> log = made();
    check::holds(
        log.position.size() > 100 && log.position.size() == position.size() && log.command.size() == command.size(),
        name + ": rows");
    std::size_t apart = 0;
    for (std::size_t k = 0; k < log.position.size() && k < position.size(); ++k)
      apart += log.position[k] != position[k] || log.command[k] != command[k];
    check::holds(apart == 0, name + ": " + std::to_string(apart) + " rows differ from Python's");
  }

 private:
  std::string item_name;
};

void judge_all(const char* path) {
  std::ifstream file(path);
  Run run;
  for (std::string line, item; std::getline(file, line);) {
    Words words(line);
    words >> item;
    if (item == "run") {
      run = Run();
      words >> run.name;
      run.controller = parameters_named(run.name);
    } else if (item == "end") {
      run.judge();
    } else {
      run.take(item, words);
    }
  }
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::printf("runs FILE\n");
    return 2;
  }
  judge_all(arguments[1]);
  return check::status();
}
