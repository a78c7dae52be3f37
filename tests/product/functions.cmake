# The libraries of the product call no function of the C library whose last bits depend on the processor, the version or
# the architecture: kernels/core/portable_functions.h and portable_angles.h have those that are the same everywhere.
#   cmake "-DLIBRARIES=<archives>" -P functions.cmake
set(functions "exp|exp2|exp10|expm1|log|log2|log10|log1p|pow|sin|cos|tan|sincos|asin|acos|atan|atan2|sinh|cosh|tanh|asinh|acosh|atanh|cbrt|hypot|erf|erfc|tgamma|lgamma")
foreach(library IN LISTS LIBRARIES)
  execute_process(COMMAND nm -A -u "${library}" OUTPUT_VARIABLE symbols ERROR_QUIET COMMAND_ERROR_IS_FATAL ANY)
  if(NOT symbols MATCHES " U (_Znwm|memcpy)")
    message(FATAL_ERROR "${library}: nm names no function that is taken from elsewhere")
  endif()
  string(REGEX MATCHALL "[^\n]* U (${functions})[fl]?(@[^\n]*)?\n" found "${symbols}")
  if(found)
    string(CONCAT found ${found})
    message(FATAL_ERROR "functions whose last bits differ between processors:\n${found}")
  endif()
endforeach()
