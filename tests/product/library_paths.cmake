# No entry of a program's paths of libraries is relative or empty: the dynamic linker takes those from the working folder.
#   cmake -DPROGRAM=<program or module> -P library_paths.cmake
execute_process(COMMAND readelf -d "${PROGRAM}" OUTPUT_VARIABLE dynamic COMMAND_ERROR_IS_FATAL ANY)
if(NOT dynamic MATCHES "\\(NEEDED\\)")
  message(FATAL_ERROR "${PROGRAM}: readelf names no library")
endif()
string(REGEX MATCHALL "\\((RPATH|RUNPATH)\\)[^\n]*\\[[^]\n]*\\]" lines "${dynamic}")
foreach(line IN LISTS lines)
  string(REGEX REPLACE "^.*\\[([^]]*)\\]$" ":\\1:" paths "${line}")
  if(paths MATCHES "::" OR paths MATCHES ":[^/$:]" OR paths MATCHES ":\\$[^O{]")
    message(FATAL_ERROR "${PROGRAM} looks for libraries in the working folder: ${line}")
  endif()
endforeach()
