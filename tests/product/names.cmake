# Names of test cases that ctest would lose: a semicolon or a bracket ends one in CMake's lists, so the case is
# registered under a part of its name and nothing runs.
#   cmake -DROOT=<source folder> -P names.cmake
file(GLOB_RECURSE sources "${ROOT}/tests/*.cpp")
set(wrong "")
foreach(source ${sources})
  file(READ "${source}" text)
  # A name may stand on the line behind the parenthesis, and be written in parts.
  if(text MATCHES "TEST_CASE\\([ \n]*(\"[^\"]*\"[ \n]*)*\"[^\"]*[[;]")
    string(APPEND wrong "\n  ${source}: ${CMAKE_MATCH_0}")
  endif()
endforeach()
if(wrong)
  message(FATAL_ERROR "names of test cases with a semicolon or a bracket in${wrong}")
endif()
