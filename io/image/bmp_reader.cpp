// BMP, by lines of our own: stb_image, which Debian packages, reads no runs, fills what a cut file lacks with
// zeros, and takes colors beyond the palette from memory that nobody set, so that a run would not be
// repeated.
#include <algorithm>
#include <array>
#include <bit>

#include "io/image/color_formats.h"
#include "io/image/image_cursor.h"

namespace meander {

namespace {

constexpr std::size_t bmp_file_header_bytes = 14;

enum class BmpPacking { none, runs_of_bytes, runs_of_nibbles };

struct BmpHeader {
  std::uint32_t width = 0, height = 0, bits = 0;
  bool top_down = false;
  BmpPacking packing = BmpPacking::none;
  std::array<std::uint32_t, 3> masks{};  // of red, green and blue; only of 16 and 32 bits
  std::size_t palette_at = 0, palette_entry_bytes = 4, colors = 0;
  std::size_t pixels_at = 0;

  std::size_t row_bytes() const { return (std::uint64_t{width} * bits + 7) / 8; }
  std::size_t stride() const { return (std::uint64_t{width} * bits + 31) / 32 * 4; }
};

[[noreturn]] void fail_bmp(const std::string& what) {
  throw ItemError(Status::unreadable, "the BMP file " + what);
}

[[noreturn]] void fail_bmp_kind(const std::string& what) {
  throw ImageError(Note::image_unsupported, "BMP files " + what + " are not read");
}

std::uint64_t size_of_signed(std::uint32_t value) {
  const auto number = static_cast<std::int32_t>(value);
  return static_cast<std::uint64_t>(number < 0 ? -std::int64_t{number} : std::int64_t{number});
}

void set_bmp_masks(BmpHeader& header, std::span<const std::byte> bytes, bool stated) {
  header.masks = header.bits == 16 ? std::array<std::uint32_t, 3>{0x7C00, 0x03E0, 0x001F}
                                   : std::array<std::uint32_t, 3>{0xFF0000, 0x00FF00, 0x0000FF};
  if (!stated) return;
  ImageCursor cursor(bytes, "BMP");
  cursor.skip(bmp_file_header_bytes + 40);
  for (std::uint32_t& mask : header.masks) mask = cursor.u32();
  if ((header.masks[0] | header.masks[1] | header.masks[2]) == 0) fail_bmp("has no bits for its colours");
  for (const std::uint32_t mask : header.masks)
    if (mask != 0 && !std::has_single_bit((std::uint64_t{mask} >> std::countr_zero(mask)) + 1))
      fail_bmp("has bits of a colour that are not side by side");
}

BmpHeader bmp_header(std::span<const std::byte> bytes) {
  ImageCursor cursor(bytes, "BMP");
  cursor.skip(10);
  BmpHeader header;
  header.pixels_at = cursor.u32();
  const std::uint32_t header_bytes = cursor.u32();
  constexpr std::array<std::uint32_t, 8> kinds = {12, 16, 40, 52, 56, 64, 108, 124};
  if (std::find(kinds.begin(), kinds.end(), header_bytes) == kinds.end())
    fail_bmp("has a header of " + std::to_string(header_bytes) + " bytes");
  const bool is_short = header_bytes == 12;
  const std::uint32_t width = is_short ? cursor.u16() : cursor.u32(),
                      height = is_short ? cursor.u16() : cursor.u32();
  if (static_cast<std::int32_t>(width) < 0) fail_bmp("has a negative width");
  check_image_size(width, size_of_signed(height));
  header.width = width;
  header.height = static_cast<std::uint32_t>(size_of_signed(height));
  header.top_down = static_cast<std::int32_t>(height) < 0;
  if (cursor.u16() != 1) fail_bmp("has another number of planes than one");
  header.bits = cursor.u16();
  std::uint32_t compression = 0, stated_colors = 0;
  if (header_bytes >= 40) {
    compression = cursor.u32();
    cursor.skip(12);
    stated_colors = cursor.u32();
  }
  const bool masks = (compression == 3 || compression == 6) && header_bytes != 64;
  if (compression == 1 || compression == 2) {
    header.packing = compression == 1 ? BmpPacking::runs_of_bytes : BmpPacking::runs_of_nibbles;
    if (header.bits != (compression == 1 ? 8 : 4) || header.top_down)
      fail_bmp("has runs of another kind than its pixels");
  } else if (compression != 0 && !masks) {
    fail_bmp_kind("of compression " + std::to_string(compression));
  }
  if (masks && header.bits != 16 && header.bits != 32) fail_bmp("has masks for colours without bits");
  header.palette_at = bmp_file_header_bytes + header_bytes;
  if (masks && header_bytes == 40) header.palette_at += compression == 3 ? 12 : 16;
  if (header.pixels_at < header.palette_at) fail_bmp("has pixels within its header");

  switch (header.bits) {
    case 1:
    case 2:
    case 4:
    case 8: {
      header.palette_entry_bytes = is_short ? 3 : 4;
      const std::size_t room = (header.pixels_at - header.palette_at) / header.palette_entry_bytes,
                        most = std::size_t{1} << header.bits;
      header.colors = std::min(stated_colors == 0 ? most : std::min<std::size_t>(stated_colors, most), room);
      if (header.colors == 0) fail_bmp("has no palette");
      break;
    }
    case 16:
    case 32:
      set_bmp_masks(header, bytes, masks);
      break;
    case 24:
      break;
    default:
      fail_bmp("has " + std::to_string(header.bits) + " bits in a pixel");
  }

  if (header.pixels_at > bytes.size()) fail_bmp("ends too early");
  // Programs leave out the padding of the last row.
  if (header.packing == BmpPacking::none &&
      header.stride() * (header.height - 1) + header.row_bytes() > bytes.size() - header.pixels_at)
    fail_bmp("ends too early");
  return header;
}

using BmpPalette = std::array<std::array<std::uint8_t, 3>, 256>;

BmpPalette bmp_palette(const BmpHeader& header, std::span<const std::byte> bytes) {
  BmpPalette palette{};
  ImageCursor cursor(bytes, "BMP");
  cursor.skip(header.palette_at);
  for (std::size_t k = 0; k < header.colors; ++k) {
    for (const std::size_t channel : {2, 1, 0}) palette[k][channel] = static_cast<std::uint8_t>(cursor.u8());
    cursor.skip(header.palette_entry_bytes - 3);
  }
  return palette;
}

void set_bmp_color(const BmpHeader& header, const BmpPalette& palette, std::uint32_t color,
                   std::uint8_t* rgb) {
  if (color >= header.colors) fail_bmp("names a colour that its palette does not have");
  std::copy(palette[color].begin(), palette[color].end(), rgb);
}

void bmp_row_of_palette(const BmpHeader& header, const BmpPalette& palette, std::span<const std::byte> row,
                        std::uint8_t* rgb) {
  const std::uint32_t in_byte = 8 / header.bits, mask = (1u << header.bits) - 1;
  for (std::uint32_t x = 0; x < header.width; ++x) {
    const auto byte = std::to_integer<std::uint32_t>(row[x / in_byte]);
    set_bmp_color(header, palette, byte >> (8 - header.bits * (x % in_byte + 1)) & mask,
                  rgb + std::size_t{3} * x);
  }
}

void bmp_row_of_colors(const BmpHeader& header, std::span<const std::byte> row, std::uint8_t* rgb) {
  ImageCursor cursor(row, "BMP");
  for (std::uint32_t x = 0; x < header.width; ++x, rgb += 3) {
    if (header.bits == 24) {
      for (const std::size_t channel : {2, 1, 0}) rgb[channel] = static_cast<std::uint8_t>(cursor.u8());
      continue;
    }
    const std::uint32_t pixel = header.bits == 16 ? cursor.u16() : cursor.u32();
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const std::uint32_t mask = header.masks[channel];
      const int shift = std::countr_zero(mask);
      rgb[channel] = mask == 0 ? std::uint8_t{0} : byte_of_value((pixel & mask) >> shift, mask >> shift);
    }
  }
}

// Pixels that runs pass over have the first color.
void decode_bmp_runs(const BmpHeader& header, const BmpPalette& palette, std::span<const std::byte> bytes,
                     ColorImage& image, const CancelToken& cancel) {
  const bool nibbles = header.packing == BmpPacking::runs_of_nibbles;
  for (std::size_t p = 0; p < image.rgb.size(); p += 3) set_bmp_color(header, palette, 0, &image.rgb[p]);
  ImageCursor cursor(bytes, "BMP");
  cursor.skip(header.pixels_at);
  std::uint32_t x = 0, y = 0;  // from below
  const auto set = [&](std::uint32_t color) {
    if (x >= header.width || y >= header.height) fail_bmp("has a run beyond its pixels");
    set_bmp_color(header, palette, color,
                  &image.rgb[(std::size_t{header.height - 1 - y} * header.width + x++) * 3]);
  };
  const auto part = [&](std::uint32_t byte, std::uint32_t k) {
    return !nibbles ? byte : k % 2 == 0 ? byte >> 4 : byte & 15;
  };
  std::size_t steps = 0;
  while (y < header.height) {
    if (steps++ % 65536 == 0) cancel.check();
    if (cursor.left() == 0 && y == header.height - 1 && x == header.width) return;  // without its end mark
    const std::uint32_t count = cursor.u8(), value = cursor.u8();
    if (count > 0) {
      for (std::uint32_t k = 0; k < count; ++k) set(part(value, k));
    } else if (value == 0) {  // end of the row
      x = 0;
      ++y;
    } else if (value == 1) {  // end of the picture
      return;
    } else if (value == 2) {
      x += cursor.u8();
      y += cursor.u8();
      if (x > header.width) fail_bmp("has a run beyond its pixels");
    } else {
      std::uint32_t byte = 0, taken = 0;
      for (std::uint32_t k = 0; k < value; ++k) {
        if (!nibbles || k % 2 == 0) {
          byte = cursor.u8();
          ++taken;
        }
        set(part(byte, k));
      }
      if (taken % 2 == 1 && cursor.left() > 0) cursor.skip(1);
    }
  }
}

bool is_bmp(std::span<const std::byte> bytes) {
  return bytes.size() >= 2 && bytes[0] == std::byte{'B'} && bytes[1] == std::byte{'M'};
}

ImageMemory memory_of_bmp(std::span<const std::byte> bytes) {
  const BmpHeader header = bmp_header(bytes);
  return {std::uint64_t{3} * header.width * header.height, 1 << 16};
}

ColorImage decode_color_bmp(std::span<const std::byte> bytes, const CancelToken& cancel) {
  const BmpHeader header = bmp_header(bytes);
  const BmpPalette palette = bmp_palette(header, bytes);
  ColorImage image;
  image.width = header.width;
  image.height = header.height;
  const std::size_t row_bytes = std::size_t{3} * header.width;
  image.rgb.resize(row_bytes * header.height);
  if (header.packing != BmpPacking::none) {
    decode_bmp_runs(header, palette, bytes, image, cancel);
    return image;
  }
  for (std::size_t y = 0; y < header.height; ++y) {
    if (y % image_rows_between_checks == 0) cancel.check();
    const std::span<const std::byte> row =
        bytes.subspan(header.pixels_at + header.stride() * y, header.row_bytes());
    std::uint8_t* const rgb = image.rgb.data() + row_bytes * (header.top_down ? y : header.height - 1 - y);
    if (header.bits <= 8)
      bmp_row_of_palette(header, palette, row, rgb);
    else
      bmp_row_of_colors(header, row, rgb);
  }
  return image;
}

}  // namespace

extern const ImageFormat bmp_image_format = {"BMP", is_bmp, memory_of_bmp, decode_color_bmp};

}  // namespace meander
