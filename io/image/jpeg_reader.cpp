// JPEG by libjpeg (libjpeg-turbo), whose slow integer transform gives the same values on every processor.
#include <cstdio>
// jpeglib.h needs stdio.h in front of it.
#include <jerror.h>
#include <jpeglib.h>

#include <csetjmp>
#include <cstring>
#include <string>
#include <vector>

#include "io/image/color_formats.h"
#include "kernels/core/status.h"

namespace meander {

namespace {

// Progressive files are decoded scan by scan, and each passes over the whole picture. Encoders write about
// ten.
constexpr int most_scans = 200;
// Coefficients of whole blocks; blocks of up to four samples by four are padded at the edges.
constexpr std::uint64_t bytes_per_coefficient = 2, most_padding = 32;

// libjpeg reports errors by a function that must not return: a jump, which must not pass anything with a
// destructor. The functions that call libjpeg hold plain values only and return false with `reason` set.
struct JpegDecoder {
  jpeg_decompress_struct info{};
  jpeg_error_mgr errors{};
  jpeg_progress_mgr progress{};
  std::jmp_buf jump{};
  std::span<const std::byte> bytes;
  const CancelToken* cancel = nullptr;
  bool canceled = false, created = false;
  char reason[JMSG_LENGTH_MAX] = "out of memory";

  explicit JpegDecoder(std::span<const std::byte> content) : bytes(content) {
    info.err = jpeg_std_error(&errors);
    info.client_data = this;  // kept when the rest is set to zero
    errors.error_exit = on_error;
    errors.emit_message = on_message;
    errors.output_message = [](j_common_ptr) {};
    progress.progress_monitor = on_progress;
  }
  ~JpegDecoder() {
    if (created) jpeg_destroy_decompress(&info);
  }
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;

  static JpegDecoder& of(j_common_ptr info) { return *static_cast<JpegDecoder*>(info->client_data); }
  [[noreturn]] static void on_error(j_common_ptr info) {
    JpegDecoder& self = of(info);
    self.errors.format_message(info, self.reason);
    std::longjmp(self.jump, 1);
  }
  // Behind these warnings libjpeg invents a part of the picture. Others (stray bytes between segments, marks
  // that contradict each other) cost no pixel.
  static void on_message(j_common_ptr info, int level) {
    const int code = info->err->msg_code;
    if (level < 0 && (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER || code == JWRN_HUFF_BAD_CODE ||
                      code == JWRN_MUST_RESYNC))
      on_error(info);
  }
  static void on_progress(j_common_ptr common) {
    JpegDecoder& self = of(common);
    if (self.info.input_scan_number > most_scans) {
      std::strncpy(self.reason, "more scans than any picture needs", sizeof self.reason - 1);
      std::longjmp(self.jump, 1);
    }
    if (!self.is_stopped()) return;
    self.canceled = true;
    std::longjmp(self.jump, 1);
  }
  // The exception must not pass libjpeg; it is thrown again outside.
  bool is_stopped() const noexcept {
    if (cancel == nullptr) return false;
    try {
      cancel->check();
    } catch (...) {
      return true;
    }
    return false;
  }

  bool read_header() {
    if (setjmp(jump) != 0) return false;
    jpeg_create_decompress(&info);
    created = true;
    info.progress = &progress;
    jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    return jpeg_read_header(&info, TRUE) == JPEG_HEADER_OK;
  }

  bool start() {
    if (setjmp(jump) != 0) return false;
    const bool inks = info.jpeg_color_space == JCS_CMYK || info.jpeg_color_space == JCS_YCCK;
    info.out_color_space = inks ? JCS_CMYK : JCS_RGB;
    info.dct_method = JDCT_ISLOW;
    jpeg_start_decompress(&info);
    return true;
  }

  bool read_row(JSAMPLE* row) {
    if (setjmp(jump) != 0) return false;
    jpeg_read_scanlines(&info, &row, 1);
    return true;
  }

  bool finish() {
    if (setjmp(jump) != 0) return false;
    jpeg_finish_decompress(&info);
    return true;
  }
};

[[noreturn]] void fail_decoding_jpeg(const JpegDecoder& decoder) {
  if (decoder.canceled) decoder.cancel->check();
  throw ItemError(Status::unreadable, std::string("the JPEG file cannot be decoded: ") + decoder.reason);
}

// Adobe's programs store paper as 255.
void inks_to_rgb(const JSAMPLE* inks, std::size_t width, bool inverted, std::uint8_t* rgb) {
  const auto light = [&](JSAMPLE ink) { return static_cast<unsigned>(inverted ? ink : 255 - ink); };
  for (std::size_t x = 0; x < width; ++x)
    for (std::size_t c = 0; c < 3; ++c)
      rgb[3 * x + c] =
          static_cast<std::uint8_t>((light(inks[4 * x + c]) * light(inks[4 * x + 3]) + 127) / 255);
}

bool is_jpeg(std::span<const std::byte> bytes) {
  return bytes.size() >= 3 && bytes[0] == std::byte{0xFF} && bytes[1] == std::byte{0xD8} &&
         bytes[2] == std::byte{0xFF};
}

ImageMemory memory_of_jpeg(std::span<const std::byte> bytes) {
  JpegDecoder decoder(bytes);
  if (!decoder.read_header()) fail_decoding_jpeg(decoder);
  jpeg_decompress_struct& info = decoder.info;
  check_image_size(info.image_width, info.image_height);
  const std::uint64_t width = info.image_width, height = info.image_height;
  ImageMemory memory{3 * width * height, 1 << 20};
  if (jpeg_has_multiple_scans(&info) != FALSE)
    memory.working_bytes += bytes_per_coefficient * static_cast<std::uint64_t>(info.num_components) *
                            (width + most_padding) * (height + most_padding);
  return memory;
}

ColorImage decode_color_jpeg(std::span<const std::byte> bytes, const CancelToken& cancel) {
  JpegDecoder decoder(bytes);
  decoder.cancel = &cancel;
  if (!decoder.read_header()) fail_decoding_jpeg(decoder);
  ColorImage image;
  image.width = decoder.info.image_width;
  image.height = decoder.info.image_height;
  check_image_size(image.width, image.height);
  if (!decoder.start()) fail_decoding_jpeg(decoder);
  const bool inks = decoder.info.out_color_space == JCS_CMYK;
  const std::size_t row_bytes = std::size_t{3} * image.width;
  image.rgb.resize(row_bytes * image.height);
  std::vector<JSAMPLE> of_inks(inks ? std::size_t{4} * image.width : 0);
  for (std::size_t y = 0; y < image.height; ++y) {
    if (y % image_rows_between_checks == 0) cancel.check();
    std::uint8_t* const row = image.rgb.data() + y * row_bytes;
    if (!decoder.read_row(inks ? of_inks.data() : row)) fail_decoding_jpeg(decoder);
    if (inks) inks_to_rgb(of_inks.data(), image.width, decoder.info.saw_Adobe_marker != FALSE, row);
  }
  if (!decoder.finish()) fail_decoding_jpeg(decoder);
  return image;
}

}  // namespace

extern const ImageFormat jpeg_image_format = {"JPEG", is_jpeg, memory_of_jpeg, decode_color_jpeg};

}  // namespace meander
