// HDF5 chunks filtered outside the library, so that workers do it in parallel and the writer only appends:
// what its pipeline shuffle, deflate, fletcher32 (or fletcher32 alone) reads back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/store/store.h"

namespace meander::store {

// The checksum of HDF5's fletcher32 filter: Fletcher's sums modulo 65535 over big-endian 16-bit words.
std::uint32_t fletcher32(std::span<const std::byte> bytes);

// Appends the filtered chunk to `out`; element_size is the size of the dataset's HDF5 type in bytes. Pure.
void append_filtered(std::span<const std::byte> chunk, std::size_t element_size, Compression compression,
                     std::vector<std::byte>& out);

// The inverse: fills `chunk`, whose size is that of the unfiltered chunk. False when the checksum, the
// compressed stream or the size is wrong.
bool unfilter(std::span<const std::byte> filtered, std::size_t element_size, Compression compression,
              std::span<std::byte> chunk);

}  // namespace meander::store
