#include "io/image/png_reader.h"

#include <png.h>

#include <csetjmp>
#include <cstring>
#include <string>

#include "io/file/file_bytes.h"
#include "io/image/color_formats.h"
#include "kernels/core/status.h"

namespace meander {

namespace {

constexpr std::size_t signature_bytes = 8;
// Two bits of deflate give 258 bytes at most.
constexpr std::uint64_t most_expansion = 1032;

// libpng reports errors by longjmp, which must not pass anything with a destructor: the functions that call
// libpng hold plain values only and return false with `reason` set.
struct Decoder {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::span<const std::byte> bytes;
  std::size_t at = 0;
  char reason[160] = "out of memory";

  explicit Decoder(std::span<const std::byte> content) : bytes(content) {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
    if (png != nullptr) info = png_create_info_struct(png);
  }
  ~Decoder() { png_destroy_read_struct(&png, &info, nullptr); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  [[noreturn]] static void on_error(png_structp png, png_const_charp message) {
    char* const reason = static_cast<Decoder*>(png_get_error_ptr(png))->reason;
    std::strncpy(reason, message, sizeof(Decoder::reason) - 1);
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp, png_const_charp) {}
  static void on_read(png_structp png, png_bytep to, std::size_t count) {
    Decoder& self = *static_cast<Decoder*>(png_get_io_ptr(png));
    if (count > self.bytes.size() - self.at) png_error(png, "the file ends too early");
    std::memcpy(to, self.bytes.data() + self.at, count);
    self.at += count;
  }

  bool read_header() {
    if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) return false;
    png_set_read_fn(png, this, on_read);
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);  // checked by the caller, against the file
    png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_WARN_DISCARD);
    png_read_info(png, info);
    return true;
  }

  // From here on rows are gray or RGB of 8 or 16 bits (big-endian); returns the passes over the picture.
  bool set_transformations(int& passes) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    const int type = png_get_color_type(png, info);
    if (type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
    if (type == PNG_COLOR_TYPE_GRAY) png_set_expand_gray_1_2_4_to_8(png);
    png_set_strip_alpha(png);
    passes = png_set_interlace_handling(png);
    png_read_update_info(png, info);
    return true;
  }

  // From here on rows are RGB of 8 bits.
  bool set_color_transformations(int& passes) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_set_expand(png);
    png_set_scale_16(png);
    png_set_strip_alpha(png);
    png_set_gray_to_rgb(png);
    passes = png_set_interlace_handling(png);
    png_read_update_info(png, info);
    return true;
  }

  bool read_row(png_bytep row) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_read_row(png, row, nullptr);
    return true;
  }

  bool read_end() {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_read_end(png, nullptr);
    return true;
  }
};

[[noreturn]] void fail(const std::string& what) { throw ItemError(Status::unreadable, what); }

[[noreturn]] void fail_decoding(const Decoder& decoder) {
  fail(std::string("the PNG file cannot be decoded: ") + decoder.reason);
}

std::string size_of(std::uint32_t width, std::uint32_t height) {
  return std::to_string(width) + " x " + std::to_string(height) + " pixels";
}

// Gray values of one row. Integer weights: a gray pixel of RGB has the value that it has in a gray picture.
void append_row(const png_byte* row, std::size_t width, bool color, bool wide, std::vector<float>& values) {
  const auto sample = [&](std::size_t k) -> std::uint64_t {
    return wide ? std::uint64_t{row[2 * k]} << 8 | row[2 * k + 1] : row[k];
  };
  const double white = wide ? 65535 : 255;
  for (std::size_t x = 0; x < width; ++x) {
    const std::uint64_t luma =
        color ? 2126 * sample(3 * x) + 7152 * sample(3 * x + 1) + 722 * sample(3 * x + 2) : 10000 * sample(x);
    values.push_back(static_cast<float>(static_cast<double>(luma) / (10000 * white)));
  }
}

// Checks the size that the header of a decoder promises.
void check_promise(const Decoder& decoder, std::uint32_t width, std::uint32_t height) {
  if (png_get_rowbytes(decoder.png, decoder.info) > decoder.bytes.size() * most_expansion / height)
    fail("the header promises " + size_of(width, height) + ", more than " +
         std::to_string(decoder.bytes.size()) + " bytes can hold");
}

bool is_png(std::span<const std::byte> bytes) {
  return bytes.size() >= signature_bytes &&
         png_sig_cmp(reinterpret_cast<png_const_bytep>(bytes.data()), 0, signature_bytes) == 0;
}

// The header is the first chunk.
ImageMemory memory_of_png(std::span<const std::byte> bytes) {
  constexpr std::size_t width_at = 16, height_at = 20, depth_at = 24, type_at = 25, end = 26;
  if (bytes.size() < end) fail("the PNG file ends in its header");
  const auto word = [&](std::size_t at) {
    return png_get_uint_32(reinterpret_cast<png_const_bytep>(bytes.data()) + at);
  };
  const std::uint64_t width = word(width_at), height = word(height_at);
  check_image_size(width, height);
  const auto type = static_cast<int>(bytes[type_at]);
  const std::uint64_t channels = type == PNG_COLOR_TYPE_RGB ? 3 : type == PNG_COLOR_TYPE_RGB_ALPHA ? 4 : 1;
  const std::uint64_t row_bytes = (width * channels * static_cast<std::uint64_t>(bytes[depth_at]) + 7) / 8;
  if (row_bytes > bytes.size() * most_expansion / height) fail("the PNG file promises more than it holds");
  return {3 * width * height, (1 << 20) + 16 * width};
}

ColorImage decode_color_png(std::span<const std::byte> bytes, const CancelToken& cancel) {
  Decoder decoder(bytes);
  if (!decoder.read_header()) fail_decoding(decoder);
  ColorImage image;
  image.width = png_get_image_width(decoder.png, decoder.info);
  image.height = png_get_image_height(decoder.png, decoder.info);
  check_image_size(image.width, image.height);
  check_promise(decoder, image.width, image.height);
  int passes = 1;
  if (!decoder.set_color_transformations(passes)) fail_decoding(decoder);
  const std::size_t row_bytes = std::size_t{3} * image.width;
  if (png_get_rowbytes(decoder.png, decoder.info) != row_bytes) fail("the PNG file cannot be made RGB");
  image.rgb.resize(row_bytes * image.height);
  for (int pass = 0; pass < passes; ++pass)
    for (std::size_t y = 0; y < image.height; ++y) {
      if (y % image_rows_between_checks == 0) cancel.check();
      if (!decoder.read_row(image.rgb.data() + y * row_bytes)) fail_decoding(decoder);
    }
  if (!decoder.read_end()) fail_decoding(decoder);
  return image;
}

}  // namespace

extern const ImageFormat png_image_format = {"PNG", is_png, memory_of_png, decode_color_png};

GrayImage decode_gray_png(std::span<const std::byte> bytes, std::uint64_t most_bytes) {
  if (!is_png(bytes)) fail("not a PNG file: it does not begin with the PNG signature");
  Decoder decoder(bytes);
  if (!decoder.read_header()) fail_decoding(decoder);

  GrayImage image;
  image.width = png_get_image_width(decoder.png, decoder.info);
  image.height = png_get_image_height(decoder.png, decoder.info);
  check_promise(decoder, image.width, image.height);
  int passes = 1;
  if (!decoder.set_transformations(passes)) fail_decoding(decoder);
  const std::size_t row_bytes = png_get_rowbytes(decoder.png, decoder.info);
  const bool interlaced = passes > 1;  // rows are complete only after the last pass: all are kept
  const std::uint64_t memory_of_row = 4 * std::uint64_t{image.width} + (interlaced ? row_bytes : 0);
  if (memory_of_row > most_bytes / image.height)
    fail(size_of(image.width, image.height) + " need more memory than the " + std::to_string(most_bytes) +
         " bytes allowed");

  const bool color = (png_get_color_type(decoder.png, decoder.info) & PNG_COLOR_MASK_COLOR) != 0;
  const bool wide = png_get_bit_depth(decoder.png, decoder.info) == 16;
  image.values.reserve(std::size_t{image.width} * image.height);
  std::vector<png_byte> rows(interlaced ? row_bytes * image.height : row_bytes);
  for (int pass = 0; pass < passes; ++pass)
    for (std::size_t y = 0; y < image.height; ++y) {
      png_byte* const row = rows.data() + (interlaced ? y * row_bytes : 0);
      if (!decoder.read_row(row)) fail_decoding(decoder);
      if (pass + 1 == passes) append_row(row, image.width, color, wide, image.values);
    }
  if (!decoder.read_end()) fail_decoding(decoder);
  return image;
}

GrayImage read_gray_png(const std::filesystem::path& path, std::uint64_t most_bytes) {
  const FileBytes file(path);
  return decode_gray_png(file.bytes(), most_bytes);
}

}  // namespace meander
