# Included by checks of the sources of kernels, io, pipeline and jobs below ROOT: fails with COMPLAINT and the lines
# that match FORBIDDEN. Sources whose path matches EXCEPT are free.
file(GLOB_RECURSE sources RELATIVE ${ROOT}
     ${ROOT}/kernels/*.h ${ROOT}/kernels/*.cpp ${ROOT}/io/*.h ${ROOT}/io/*.cpp
     ${ROOT}/pipeline/*.h ${ROOT}/pipeline/*.cpp ${ROOT}/jobs/*.h ${ROOT}/jobs/*.cpp)
list(FILTER sources EXCLUDE REGEX "${EXCEPT}")
list(LENGTH sources count)
if(count LESS 100)
  message(FATAL_ERROR "only ${count} sources were found in ${ROOT}")
endif()
set(problems "")
foreach(source ${sources})
  file(STRINGS ${ROOT}/${source} found REGEX "${FORBIDDEN}")
  foreach(line ${found})
    string(APPEND problems "${source}: ${line}\n")
  endforeach()
endforeach()
if(problems)
  message(FATAL_ERROR "${COMPLAINT}:\n${problems}")
endif()
