# find_package(cogging) gives cogging::core: headers, C++20, and threads where the machine has them.
find_package(Threads QUIET)
include("${CMAKE_CURRENT_LIST_DIR}/coggingTargets.cmake")
