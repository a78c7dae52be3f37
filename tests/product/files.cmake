# cmake -DROOT=... -P files.cmake: files are opened, renamed, synced and mapped by io/file alone.
file(GLOB_RECURSE sources RELATIVE ${ROOT}
     ${ROOT}/kernels/*.h ${ROOT}/kernels/*.cpp ${ROOT}/io/*.h ${ROOT}/io/*.cpp
     ${ROOT}/pipeline/*.h ${ROOT}/pipeline/*.cpp ${ROOT}/jobs/*.h ${ROOT}/jobs/*.cpp)
list(FILTER sources EXCLUDE REGEX "^io/file/")
list(REMOVE_ITEM sources jobs/standard_streams.cpp)  # standard input and output where they are closed
list(LENGTH sources count)
if(count LESS 100)
  message(FATAL_ERROR "only ${count} sources were found in ${ROOT}")
endif()
set(problems "")
foreach(source ${sources})
  file(STRINGS ${ROOT}/${source} found
       REGEX "[io]?fstream|fopen\\(|[^a-zA-Z]::(open|rename|fsync|fdatasync|mmap|write|pwrite)\\(|fs::rename\\(")
  foreach(line ${found})
    string(APPEND problems "${source}: ${line}\n")
  endforeach()
endforeach()
if(problems)
  message(FATAL_ERROR "files are opened or renamed outside of io/file:\n${problems}")
endif()
