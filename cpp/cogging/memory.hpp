#pragma once
// What a call asks of memory is compared with what the process may still take, before any of it is taken: a system that
// has promised more than it has ends the process without a word.

#include <algorithm>
#include <fstream>
#include <limits>

#include "cogging/require.hpp"

#if __has_include(<unistd.h>) && __has_include(<sys/resource.h>)
#include <sys/resource.h>
#include <unistd.h>
#endif

namespace cogging {

namespace detail {

inline constexpr double no_memory_limit = std::numeric_limits<double>::infinity();

/// The number that stands behind a word at the beginning of a line of a file; infinite where there is none, as `max` of
/// a control group is none.
inline double number_in_file(const std::string& path, const std::string& word = "") {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(word)) continue;
    char* end = nullptr;
    const double found = std::strtod(line.c_str() + word.size(), &end);
    return end == line.c_str() + word.size() ? no_memory_limit : found;
  }
  return no_memory_limit;
}

/// Bytes that a control group of Linux and those around it leave; what it holds of files can be given back.
inline double memory_of_group(const std::string& root, std::string group, const char* most, const char* used,
                              const char* given_back) {
  double left = no_memory_limit;
  while (true) {
    const std::string folder = root + group + "/";
    const double limit = number_in_file(folder + most);
    if (limit < 1e18) {  // version 1 writes the largest number of pages where there is none
      const double files = number_in_file(folder + "memory.stat", given_back);
      left = std::min(left, limit - number_in_file(folder + used) + (files < no_memory_limit ? files : 0.0));
    }
    const std::size_t above = group.find_last_of('/');
    if (above == std::string::npos || group == "/") return left;
    group.resize(above);
  }
}

inline double memory_of_groups() {
  double left = no_memory_limit;
  std::ifstream file("/proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {  // number:controllers:path
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const bool of_memory = line.find("memory", first) < second;
    // In a container the path may be that outside; the root is then the container's own.
    for (const std::string& group : {line.substr(second + 1), std::string()})
      if (second == first + 1)
        left =
            std::min(left, memory_of_group("/sys/fs/cgroup", group, "memory.max", "memory.current", "inactive_file "));
      else if (of_memory)
        left = std::min(left, memory_of_group("/sys/fs/cgroup/memory", group, "memory.limit_in_bytes",
                                              "memory.usage_in_bytes", "total_inactive_file "));
  }
  return left;
}

/// Bytes of addresses that this process may still take (ulimit -v).
inline double memory_of_addresses() {
#if __has_include(<unistd.h>) && __has_include(<sys/resource.h>)
  rlimit limit{};
  const double pages = number_in_file("/proc/self/statm");
  if (pages < no_memory_limit && getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    return static_cast<double>(limit.rlim_cur) - pages * static_cast<double>(sysconf(_SC_PAGESIZE));
#endif
  return no_memory_limit;
}

/// Bytes that the machine has left; where the system does not say so, half of what it has, or 8 GiB (both assumed).
inline double memory_of_machine() {
  const double kilobytes = number_in_file("/proc/meminfo", "MemAvailable:");
  if (kilobytes < no_memory_limit) return 1024.0 * kilobytes;
#if defined(_SC_PHYS_PAGES) && defined(_SC_PAGESIZE)
  const double pages = static_cast<double>(sysconf(_SC_PHYS_PAGES));
  if (pages > 0.0) return 0.5 * pages * static_cast<double>(sysconf(_SC_PAGESIZE));
#endif
  return 8.0 * 1024.0 * 1024.0 * 1024.0;
}

}  // namespace detail

/// Bytes that this process may still take: what the machine has left, no more than control groups (1 and 2) and the
/// limit of addresses allow.
inline double memory_left() {
  const double left =
      std::min({detail::memory_of_machine(), detail::memory_of_groups(), detail::memory_of_addresses()});
  return std::max(left, 0.0);
}

/// A size in memory, in words.
inline std::string in_bytes(double bytes) {
  char text[40];
  const bool small = bytes < 1e9;
  std::snprintf(text, sizeof text, "%.3g %s", small ? bytes * 1e-6 : bytes * 1e-9, small ? "MB" : "GB");
  return text;
}

inline constexpr double memory_unasked = 64e6;  // bytes: for so few the system is not asked
inline constexpr double memory_granted = 0.8;   // of what is left: what looks at columns takes one or two beside them

/// Refuses what would not fit into memory, before any of it is taken.
///
/// `bytes` is what is asked, `what` says of what, and `value` is that of the field `name`, which asks for it.
inline void require_memory(std::string_view name, double bytes, const std::string& what, const std::string& value) {
  if (bytes <= memory_unasked) return;
  const double left = memory_left();
  if (bytes > memory_granted * left)
    refuse(name, "must fit into memory: " + what + " take " + in_bytes(bytes) + " and " + in_bytes(left) + " are free",
           value);
}

}  // namespace cogging
