# cmake -DROOT=... -DINCLUDES=regex -P includes.cmake: no source of the product includes a header of the laboratory.
set(EXCEPT "^(kernels/(analyse|pointset|render)|io/plot|jobs/laboratory)/")
set(FORBIDDEN "${INCLUDES}")
set(COMPLAINT "the product includes the laboratory")
include(${CMAKE_CURRENT_LIST_DIR}/lines.cmake)
