# cmake -DROOT=... -P files.cmake: files are opened, renamed, synced and mapped by io/file alone.
set(EXCEPT "^(io/file/|jobs/cli/working_process.cpp$)")  # standard input and output where they are closed
set(FORBIDDEN "[io]?fstream|fopen\\(|[^a-zA-Z]::(open|rename|fsync|fdatasync|mmap|write|pwrite)\\(|fs::rename\\(")
set(COMPLAINT "files are opened or renamed outside of io/file")
include(${CMAKE_CURRENT_LIST_DIR}/lines.cmake)
