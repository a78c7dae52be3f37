// BMP, TGA and GIF files that tests make, byte by byte, of every kind. They need no library.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/image_files.h"

namespace meander::test {

using ImageColor = std::array<std::uint8_t, 3>;

inline ImageColor color_at(const TestImage& image, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t* const pixel = image.rgb.data() + std::size_t{3} * (std::size_t{y} * image.width + x);
  return {pixel[0], pixel[1], pixel[2]};
}

inline void append_number(std::string& bytes, std::uint32_t value, std::size_t size) {
  for (std::size_t k = 0; k < size; ++k) bytes += static_cast<char>(value >> (8 * k));
}

// The colors of an image in the order in which they come, and their numbers.
class ImagePalette {
 public:
  explicit ImagePalette(const TestImage& image) {
    for (std::uint32_t y = 0; y < image.height; ++y)
      for (std::uint32_t x = 0; x < image.width; ++x)
        if (numbers_.try_emplace(color_at(image, x, y), colors.size()).second)
          colors.push_back(color_at(image, x, y));
  }
  std::uint32_t number(const ImageColor& color) const {
    return static_cast<std::uint32_t>(numbers_.at(color));
  }

  std::vector<ImageColor> colors;

 private:
  std::map<ImageColor, std::size_t> numbers_;
};

struct BmpKind {
  unsigned bits = 24;
  bool top_down = false, runs = false;
  std::uint32_t header_bytes = 40;
  std::array<std::uint32_t, 3> masks{};  // all zero: none
};

// The value of 8 bits in the bits of a mask, rounded down.
inline std::uint32_t in_mask(std::uint8_t value, std::uint32_t mask) {
  if (mask == 0) return 0;
  const int width = std::popcount(mask);
  const std::uint32_t bits = width <= 8 ? value >> (8 - width) : std::uint32_t{value} << (width - 8);
  return bits << std::countr_zero(mask);
}

inline void append_bmp_runs(std::string& pixels, const std::vector<std::uint32_t>& row, unsigned bits) {
  for (std::size_t x = 0; x < row.size();) {
    std::size_t same = x;
    while (same < row.size() && row[same] == row[x] && same - x < 255) ++same;
    const std::size_t rest = std::min<std::size_t>(row.size() - x, 5);
    if (same - x == 1 && rest >= 3) {  // as they are
      pixels += '\0';
      append_number(pixels, static_cast<std::uint32_t>(rest), 1);
      std::size_t taken = 0;
      for (std::size_t k = 0; k < rest; k += bits == 4 ? 2 : 1, ++taken)
        append_number(pixels, bits == 8 ? row[x + k] : row[x + k] << 4 | (k + 1 < rest ? row[x + k + 1] : 0),
                      1);
      if (taken % 2 == 1) pixels += '\0';
      x += rest;
    } else {
      append_number(pixels, static_cast<std::uint32_t>(same - x), 1);
      append_number(pixels, bits == 8 ? row[x] : row[x] << 4 | row[x], 1);
      x = same;
    }
  }
  pixels.append(2, '\0');
}

inline std::string bmp_bytes(const TestImage& image, const BmpKind& kind = {}) {
  const ImagePalette palette(image);
  const bool masked = kind.masks != std::array<std::uint32_t, 3>{};
  std::array<std::uint32_t, 3> masks = kind.masks;
  if (!masked && kind.bits == 16) masks = {0x7C00, 0x03E0, 0x001F};
  if (!masked && kind.bits == 32) masks = {0xFF0000, 0x00FF00, 0x0000FF};
  std::string pixels;
  for (std::uint32_t k = 0; k < image.height; ++k) {
    const std::uint32_t y = kind.top_down ? k : image.height - 1 - k;
    std::vector<std::uint32_t> row;
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const ImageColor color = color_at(image, x, y);
      if (kind.bits <= 8)
        row.push_back(palette.number(color));
      else if (kind.bits == 24)
        row.push_back(color[2] | std::uint32_t{color[1]} << 8 | std::uint32_t{color[0]} << 16);
      else
        row.push_back(in_mask(color[0], masks[0]) | in_mask(color[1], masks[1]) |
                      in_mask(color[2], masks[2]));
    }
    if (kind.runs) {
      append_bmp_runs(pixels, row, kind.bits);
      continue;
    }
    const std::size_t begin = pixels.size();
    std::uint32_t byte = 0;
    for (std::size_t x = 0; x < row.size(); ++x) {
      if (kind.bits >= 16) {
        append_number(pixels, row[x], kind.bits / 8);
        continue;
      }
      byte = byte << kind.bits | row[x];
      if ((x + 1) * kind.bits % 8 == 0 || x + 1 == row.size()) {
        const std::size_t filled = (x * kind.bits) % 8 + kind.bits;
        append_number(pixels, byte << (8 - filled), 1);
        byte = 0;
      }
    }
    while ((pixels.size() - begin) % 4 != 0) pixels += '\0';
  }
  if (kind.runs) pixels += std::string("\0\1", 2);

  std::string header;
  const bool is_short = kind.header_bytes == 12;
  append_number(header, kind.header_bytes, 4);
  append_number(header, image.width, is_short ? 2 : 4);
  append_number(header, kind.top_down ? 0u - image.height : image.height, is_short ? 2 : 4);
  append_number(header, 1, 2);
  append_number(header, kind.bits, 2);
  if (kind.header_bytes >= 40) {
    append_number(header, kind.runs ? (kind.bits == 8 ? 1 : 2) : masked ? 3 : 0, 4);
    append_number(header, static_cast<std::uint32_t>(pixels.size()), 4);
    append_number(header, 2835, 4);
    append_number(header, 2835, 4);
    append_number(header, kind.bits <= 8 ? static_cast<std::uint32_t>(palette.colors.size()) : 0, 4);
    append_number(header, 0, 4);
    if (masked)
      for (const std::uint32_t mask : masks) append_number(header, mask, 4);
  }
  header.resize(std::max<std::size_t>(header.size(), kind.header_bytes), '\0');
  if (kind.bits <= 8) {
    const std::size_t room = std::size_t{1} << kind.bits;
    if (palette.colors.size() > room) throw std::logic_error("too many colors for the palette");
    // The short header has no number of colors: all that the bits can name.
    for (std::size_t k = 0; k < (is_short ? room : palette.colors.size()); ++k) {
      const ImageColor color = k < palette.colors.size() ? palette.colors[k] : ImageColor{};
      for (const std::size_t channel : {2, 1, 0}) append_number(header, color[channel], 1);
      if (!is_short) header += '\0';
    }
  }
  std::string bytes = "BM";
  append_number(bytes, static_cast<std::uint32_t>(14 + header.size() + pixels.size()), 4);
  append_number(bytes, 0, 4);
  append_number(bytes, static_cast<std::uint32_t>(14 + header.size()), 4);
  return bytes + header + pixels;
}

struct TgaKind {
  unsigned bits = 24;
  bool palette = false, gray = false, runs = false, top_down = false, from_right = false, footer = false;
  unsigned palette_bits = 24;
  std::uint32_t first_color = 0;
};

inline void append_tga_color(std::string& bytes, const ImageColor& color, unsigned bits) {
  if (bits <= 16) {
    append_number(
        bytes,
        std::uint32_t{color[2]} >> 3 | std::uint32_t{color[1]} >> 3 << 5 | std::uint32_t{color[0]} >> 3 << 10,
        2);
    return;
  }
  for (const std::size_t channel : {2, 1, 0}) append_number(bytes, color[channel], 1);
  if (bits == 32) bytes += '\x80';
}

// Of gray ones the red values.
inline std::string tga_bytes(const TestImage& image, const TgaKind& kind = {}) {
  const ImagePalette palette(image);
  std::string bytes;
  append_number(bytes, 3, 1);
  append_number(bytes, kind.palette ? 1 : 0, 1);
  append_number(bytes, (kind.palette ? 1u : kind.gray ? 3u : 2u) | (kind.runs ? 8u : 0u), 1);
  append_number(bytes, kind.palette ? kind.first_color : 0, 2);
  append_number(bytes, kind.palette ? static_cast<std::uint32_t>(palette.colors.size()) : 0, 2);
  append_number(bytes, kind.palette ? kind.palette_bits : 0, 1);
  append_number(bytes, 0, 4);
  append_number(bytes, image.width, 2);
  append_number(bytes, image.height, 2);
  append_number(bytes, kind.bits, 1);
  append_number(
      bytes, (kind.bits == 32 ? 8u : 0u) | (kind.from_right ? 0x10u : 0u) | (kind.top_down ? 0x20u : 0u), 1);
  bytes += "by ";
  if (kind.palette)
    for (const ImageColor& color : palette.colors) append_tga_color(bytes, color, kind.palette_bits);
  for (std::uint32_t k = 0; k < image.height; ++k) {
    std::vector<std::string> row;
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const ImageColor color = color_at(image, kind.from_right ? image.width - 1 - x : x,
                                        kind.top_down ? k : image.height - 1 - k);
      std::string pixel;
      if (kind.palette)
        append_number(pixel, palette.number(color) + kind.first_color, kind.bits / 8);
      else if (kind.gray)
        append_number(pixel, color[0], kind.bits / 8);
      else
        append_tga_color(pixel, color, kind.bits);
      row.push_back(pixel);
    }
    for (std::size_t x = 0; x < row.size();) {
      std::size_t same = x;
      while (same < row.size() && row[same] == row[x] && same - x < 128) ++same;
      const std::size_t raw = kind.runs ? std::min<std::size_t>(row.size() - x, 3) : row.size();
      if (kind.runs && same - x > 1) {
        append_number(bytes, static_cast<std::uint32_t>(127 + (same - x)), 1);
        bytes += row[x];
        x = same;
      } else {
        if (kind.runs) append_number(bytes, static_cast<std::uint32_t>(raw - 1), 1);
        for (const std::size_t end = x + raw; x < end; ++x) bytes += row[x];
      }
    }
  }
  if (kind.footer) bytes += std::string(8, '\0') + std::string("TRUEVISION-XFILE.\0", 18);
  return bytes;
}

struct GifKind {
  bool interlaced = false, local_palette = false, transparent = false;
  std::uint32_t width = 0, height = 0, x = 0, y = 0;  // of the whole, and where the picture lies; 0: as large
  std::uint32_t background = 0;
  std::uint32_t frames = 1;
};

// Codes of variable length, packed in parts of up to 255 bytes.
inline std::string gif_codes(const std::vector<std::uint8_t>& pixels, unsigned first_bits) {
  const std::uint32_t clear = 1u << first_bits;
  std::string packed;
  std::uint32_t buffer = 0;
  unsigned bits = 0, width = first_bits + 1;
  const auto put = [&](std::uint32_t code) {
    buffer |= code << bits;
    for (bits += width; bits >= 8; bits -= 8, buffer >>= 8) packed += static_cast<char>(buffer & 255);
  };
  std::map<std::pair<std::uint32_t, std::uint8_t>, std::uint32_t> table;
  std::uint32_t next = clear + 2;
  put(clear);
  std::uint32_t current = pixels.at(0);
  for (std::size_t k = 1; k < pixels.size(); ++k) {
    const auto found = table.find({current, pixels[k]});
    if (found != table.end()) {
      current = found->second;
      continue;
    }
    put(current);
    if (next == 4096) {
      put(clear);
      table.clear();
      next = clear + 2;
      width = first_bits + 1;
    } else {
      if (next == 1u << width) ++width;
      table[{current, pixels[k]}] = next++;
    }
    current = pixels[k];
  }
  put(current);
  // The reader has made an entry for the code before it.
  if (next == 1u << width && width < 12) ++width;
  put(clear + 1);
  if (bits > 0) packed += static_cast<char>(buffer & 255);
  std::string parts(1, static_cast<char>(first_bits));
  for (std::size_t at = 0; at < packed.size(); at += 255) {
    const std::string part = packed.substr(at, 255);
    append_number(parts, static_cast<std::uint32_t>(part.size()), 1);
    parts += part;
  }
  return parts + '\0';
}

inline std::string gif_bytes(const TestImage& image, const GifKind& kind = {}) {
  const ImagePalette palette(image);
  if (palette.colors.size() > 256) throw std::logic_error("too many colors for the palette");
  unsigned bits = 1;
  while (std::size_t{1} << bits < palette.colors.size()) ++bits;
  const auto append_palette = [&](std::string& bytes) {
    for (std::size_t k = 0; k < std::size_t{1} << bits; ++k)
      for (std::size_t channel = 0; channel < 3; ++channel)
        append_number(bytes, k < palette.colors.size() ? palette.colors[k][channel] : 0, 1);
  };
  std::string bytes = "GIF89a";
  append_number(bytes, kind.width == 0 ? image.width : kind.width, 2);
  append_number(bytes, kind.height == 0 ? image.height : kind.height, 2);
  append_number(bytes, kind.local_palette ? 0x80u : 0x80u | (bits - 1), 1);
  append_number(bytes, kind.background, 1);
  append_number(bytes, 0, 1);
  if (kind.local_palette)
    bytes += std::string("\1\2\3\4\5\6", 6);
  else
    append_palette(bytes);
  bytes += std::string("\x21\xFE\x05hello\0", 9);
  std::vector<std::uint32_t> rows;
  if (kind.interlaced)
    for (const auto& [begin, step] : {std::pair{0u, 8u}, {4u, 8u}, {2u, 4u}, {1u, 2u}})
      for (std::uint32_t y = begin; y < image.height; y += step) rows.push_back(y);
  else
    for (std::uint32_t y = 0; y < image.height; ++y) rows.push_back(y);
  for (std::uint32_t frame = 0; frame < kind.frames; ++frame) {
    bytes += std::string("\x21\xF9\x04", 3);
    append_number(bytes, kind.transparent ? 1 : 0, 1);
    append_number(bytes, 10, 2);
    append_number(bytes, 0, 2);  // the first color is the transparent one
    bytes += '\x2C';
    for (const std::uint32_t number : {kind.x, kind.y, image.width, image.height})
      append_number(bytes, number, 2);
    append_number(bytes, (kind.local_palette ? 0x80u | (bits - 1) : 0u) | (kind.interlaced ? 0x40u : 0u), 1);
    if (kind.local_palette) append_palette(bytes);
    std::vector<std::uint8_t> pixels;
    for (const std::uint32_t y : rows)
      for (std::uint32_t x = 0; x < image.width; ++x)
        pixels.push_back(static_cast<std::uint8_t>(palette.number(color_at(image, x, frame == 0 ? y : 0))));
    bytes += gif_codes(pixels, std::max(bits, 2u));
  }
  return bytes + '\x3B';
}

}  // namespace meander::test
