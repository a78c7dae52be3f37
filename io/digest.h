// SHA-256 of a file's bytes: the content that all randomness of a model is keyed by.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace meander {

// For a program, before its first digest: reading the configuration file of OpenSSL, which nothing here
// depends on, takes as long as the digest of a small model. It holds for the whole process, so a library
// leaves it alone.
void leave_out_openssl_configuration();

// About 0.4 GB/s without, 1.5 GB/s with SHA instructions. Throws std::runtime_error when OpenSSL fails.
std::array<std::uint8_t, 32> sha256(std::span<const std::byte> bytes);

// Two lower-case hexadecimal digits a byte.
std::string hex_text(std::span<const std::uint8_t> bytes);

}  // namespace meander
