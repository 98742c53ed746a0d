#pragma once
// Net forces of many plants along one motion.

#include <span>
#include <vector>

#include "cogging/estimation/predictor.hpp"

/// Command that acts plus all forces, V, of many plants along a motion given half-way between rows: (plants, rows);
/// side by side those that share a course, each with the bits that it has alone.
///
/// Raises std::invalid_argument for columns that are not as long as the log.
std::vector<double> net_forces(const cogging::Predictor& predictor, const std::vector<cogging::Plant<>>& plants,
                               std::span<const double> middle_position, std::span<const double> middle_velocity,
                               unsigned threads, cogging::StopRequest* stop);
