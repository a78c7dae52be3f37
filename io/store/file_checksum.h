// The checksum of a file as it lies on disk.
#pragma once

#include <cstdint>
#include <filesystem>

#include "io/file/file_descriptor.h"

namespace meander::store {

// CRC32C of the bytes [begin, end of file). Read in blocks by as many threads as this process may use, at
// most eight; the result does not depend on them. The threads are gone when this returns, so that the caller
// may still fork. From the page cache about 5 GB/s with one thread; else as fast as the disk reads. Throws
// RunError.
std::uint32_t checksum_of_file(const FileDescriptor& file, std::uint64_t begin,
                               const std::filesystem::path& path);

// The same with that many threads, 1 or more: for benches and tests.
std::uint32_t checksum_of_file(const FileDescriptor& file, std::uint64_t begin,
                               const std::filesystem::path& path, std::size_t threads);

}  // namespace meander::store
