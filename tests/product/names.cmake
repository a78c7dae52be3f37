# Names of test cases that ctest would lose: a semicolon or a bracket ends one in CMake's lists, so the case is
# registered under a part of its name and nothing runs.
#   cmake -DROOT=<source folder> -P names.cmake
file(GLOB_RECURSE sources "${ROOT}/tests/*.cpp")
set(wrong "")
foreach(source ${sources})
  file(STRINGS "${source}" lines REGEX "TEST_CASE\\(\"[^\"]*[[;]")
  if(NOT "${lines}" STREQUAL "")
    string(APPEND wrong "\n  ${source}")
  endif()
endforeach()
if(wrong)
  message(FATAL_ERROR "names of test cases with a semicolon or a bracket in${wrong}")
endif()
