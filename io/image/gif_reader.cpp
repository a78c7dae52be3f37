// GIF, its first picture, by lines of our own: stb_image, which Debian packages, makes transparent pixels
// black instead of leaving transparency to whoever asks, and fills what a cut file lacks with black. Its code
// for the pictures that follow reads beyond its buffers (CVE-2023-45661).
#include <algorithm>
#include <array>
#include <string_view>

#include "io/image/color_formats.h"
#include "io/image/image_cursor.h"
#include "io/utf8.h"

namespace meander {

namespace {

constexpr unsigned most_gif_code_bits = 12;
constexpr std::size_t most_gif_codes = std::size_t{1} << most_gif_code_bits;
// A code has two bits or more and stands for no more pixels than there are codes.
constexpr std::uint64_t most_gif_expansion = 4 * most_gif_codes;

[[noreturn]] void fail_gif(const std::string& what) {
  throw ItemError(Status::unreadable, "the GIF file " + what);
}

// The fields that precede the pixels of the first picture.
struct GifFrame {
  std::uint32_t width = 0, height = 0;  // of the whole
  std::uint32_t x = 0, y = 0, columns = 0, rows = 0;
  bool interlaced = false;
  std::span<const std::byte> palette;
  std::array<std::uint8_t, 3> background{};
  std::size_t pixels_at = 0;
};

std::array<std::uint8_t, 3> gif_color(std::span<const std::byte> palette, std::size_t number) {
  std::array<std::uint8_t, 3> color;
  for (std::size_t channel = 0; channel < 3; ++channel)
    color[channel] = std::to_integer<std::uint8_t>(palette[3 * number + channel]);
  return color;
}

std::span<const std::byte> take_gif_palette(ImageCursor& cursor, std::uint32_t flags) {
  if ((flags & 0x80) == 0) return {};
  return cursor.take(std::size_t{3} << ((flags & 7) + 1));
}

GifFrame first_gif_frame(std::span<const std::byte> bytes) {
  ImageCursor cursor(bytes, "GIF");
  cursor.skip(6);
  GifFrame frame;
  frame.width = cursor.u16();
  frame.height = cursor.u16();
  const std::uint32_t flags = cursor.u8(), background = cursor.u8();
  cursor.skip(1);
  frame.palette = take_gif_palette(cursor, flags);
  if (background < frame.palette.size() / 3) frame.background = gif_color(frame.palette, background);
  for (std::uint32_t block = cursor.u8(); block != 0x2C; block = cursor.u8()) {
    if (block == 0x3B) fail_gif("has no picture");
    if (block != 0x21) fail_gif("has a block of an unknown kind");
    cursor.skip(1);
    for (std::uint32_t part = cursor.u8(); part != 0; part = cursor.u8()) cursor.skip(part);
  }
  frame.x = cursor.u16();
  frame.y = cursor.u16();
  frame.columns = cursor.u16();
  frame.rows = cursor.u16();
  const std::uint32_t frame_flags = cursor.u8();
  frame.interlaced = (frame_flags & 0x40) != 0;
  if (const std::span<const std::byte> own = take_gif_palette(cursor, frame_flags); !own.empty())
    frame.palette = own;
  frame.pixels_at = cursor.at();
  if (frame.width == 0) frame.width = frame.x + frame.columns;
  if (frame.height == 0) frame.height = frame.y + frame.rows;
  check_image_size(frame.width, frame.height);
  check_image_size(frame.columns, frame.rows);
  if (frame.x + frame.columns > frame.width || frame.y + frame.rows > frame.height)
    fail_gif("has a picture beyond its edges");
  if (frame.palette.empty()) fail_gif("has no palette");
  if (std::uint64_t{frame.columns} * frame.rows / most_gif_expansion > bytes.size() - frame.pixels_at)
    fail_gif("ends too early");
  return frame;
}

// Codes of the picture, from parts of up to 255 bytes.
class GifCodes {
 public:
  GifCodes(std::span<const std::byte> bytes, std::size_t at) : cursor_(bytes, "GIF") { cursor_.skip(at); }

  std::uint32_t byte() { return cursor_.u8(); }
  std::uint32_t code(unsigned width) {
    while (bits_ < width) {
      if (left_of_part_ == 0) left_of_part_ = cursor_.u8();
      if (left_of_part_ == 0) fail_gif("ends too early");
      buffer_ |= cursor_.u8() << bits_;
      bits_ += 8;
      --left_of_part_;
    }
    const std::uint32_t code = buffer_ & ((1u << width) - 1);
    buffer_ >>= width;
    bits_ -= width;
    return code;
  }

 private:
  ImageCursor cursor_;
  std::uint32_t buffer_ = 0, left_of_part_ = 0;
  unsigned bits_ = 0;
};

// Puts pixels where they belong, in the order of the file.
class GifPixels {
 public:
  GifPixels(const GifFrame& frame, ColorImage& image, const CancelToken& cancel)
      : frame_(frame), image_(image), cancel_(cancel) {
    for (std::size_t k = 0; k < frame.palette.size() / 3; ++k) colors_[k] = gif_color(frame.palette, k);
  }

  bool is_done() const { return rows_done_ == frame_.rows; }
  void add(std::uint8_t number) {
    if (number >= frame_.palette.size() / 3) fail_gif("names a colour that its palette does not have");
    const std::size_t at = (std::size_t{frame_.y} + row_) * image_.width + std::size_t{frame_.x} + column_;
    std::copy(colors_[number].begin(), colors_[number].end(), image_.rgb.begin() + 3 * at);
    if (++column_ == frame_.columns) end_row();
  }

 private:
  void end_row() {
    if (++rows_done_ % image_rows_between_checks == 0) cancel_.check();
    column_ = 0;
    if (!frame_.interlaced) {
      ++row_;
      return;
    }
    // Every eighth row, those half way between them, and so on.
    constexpr std::array<std::uint32_t, 4> begin = {0, 4, 2, 1}, step = {8, 8, 4, 2};
    row_ += step[pass_];
    while (row_ >= frame_.rows && pass_ + 1 < begin.size()) row_ = begin[++pass_];
  }

  const GifFrame& frame_;
  ColorImage& image_;
  const CancelToken& cancel_;
  std::array<std::array<std::uint8_t, 3>, 256> colors_{};
  std::uint32_t row_ = 0, column_ = 0, rows_done_ = 0;
  std::size_t pass_ = 0;
};

void decode_gif_pixels(std::span<const std::byte> bytes, const GifFrame& frame, GifPixels& pixels) {
  GifCodes codes(bytes, frame.pixels_at);
  const std::uint32_t first_bits = codes.byte();
  if (first_bits < 1 || first_bits > 8) fail_gif("has codes of an unknown width");
  const std::uint32_t clear = 1u << first_bits, end = clear + 1;
  constexpr std::uint32_t none = most_gif_codes;
  // A code beyond `end` stands for the pixels of another and one more.
  std::array<std::uint16_t, most_gif_codes> before{};
  std::array<std::uint8_t, most_gif_codes> last{};
  std::array<std::uint8_t, most_gif_codes> pixels_of_code{};  // from the last one on
  std::uint32_t next = end + 1, previous = none;
  unsigned width = first_bits + 1;
  std::uint8_t first = 0;  // pixel of the previous code
  while (!pixels.is_done()) {
    const std::uint32_t code = codes.code(width);
    if (code == clear) {
      next = end + 1;
      width = first_bits + 1;
      previous = none;
      continue;
    }
    if (code == end) fail_gif("ends too early");
    const bool is_made_now = code == next && previous != none && next < most_gif_codes;
    if (code >= next && !is_made_now) fail_gif("has a code that stands for nothing");
    std::size_t count = 0;
    if (is_made_now) pixels_of_code[count++] = first;
    std::uint32_t at = is_made_now ? previous : code;
    while (at > end) {
      pixels_of_code[count++] = last[at];
      at = before[at];
    }
    first = static_cast<std::uint8_t>(at);
    pixels_of_code[count++] = first;
    if (previous != none && next < most_gif_codes) {
      before[next] = static_cast<std::uint16_t>(previous);
      last[next] = first;
      ++next;
      if (next == 1u << width && width < most_gif_code_bits) ++width;
    }
    previous = code;
    while (count > 0 && !pixels.is_done()) pixels.add(pixels_of_code[--count]);
  }
}

bool is_gif(std::span<const std::byte> bytes) {
  const std::string_view text = text_of(bytes);
  return text.starts_with("GIF87a") || text.starts_with("GIF89a");
}

ImageMemory memory_of_gif(std::span<const std::byte> bytes) {
  const GifFrame frame = first_gif_frame(bytes);
  return {std::uint64_t{3} * frame.width * frame.height, 1 << 16};
}

ColorImage decode_color_gif(std::span<const std::byte> bytes, const CancelToken& cancel) {
  cancel.check();
  const GifFrame frame = first_gif_frame(bytes);
  ColorImage image;
  image.width = frame.width;
  image.height = frame.height;
  image.rgb.resize(std::size_t{3} * frame.width * frame.height);
  if (frame.columns < frame.width || frame.rows < frame.height)
    for (std::size_t p = 0; p < image.rgb.size(); p += 3)
      std::copy(frame.background.begin(), frame.background.end(), image.rgb.begin() + p);
  GifPixels pixels(frame, image, cancel);
  decode_gif_pixels(bytes, frame, pixels);
  return image;
}

}  // namespace

extern const ImageFormat gif_image_format = {"GIF", is_gif, memory_of_gif, decode_color_gif};

}  // namespace meander
