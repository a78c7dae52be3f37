// WebP by libwebp, whose pixels are the same on every processor. The container is read here: libwebp gets the
// stream of pixels alone, of an animation that of the first picture, and no transparency to unpack.
#include <webp/decode.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string_view>

#include "io/image/color_formats.h"
#include "io/image/image_cursor.h"
#include "io/image/webp_codes.h"
#include "io/utf8.h"

namespace meander {

namespace {

[[noreturn]] void fail_webp(const std::string& what) {
  throw ItemError(Status::unreadable, "the WebP file " + what);
}

struct WebpStream {
  std::span<const std::byte> bytes;  // of the pixels
  std::span<const std::byte>
      chunk;  // the same with their name and size, without which libwebp takes a part for all
  bool lossless = false;
  std::uint32_t x = 0, y = 0, columns = 0, rows = 0;
  std::uint32_t width = 0, height = 0;  // of the whole
  std::array<std::uint8_t, 3> background{};
};

struct WebpChunk {
  std::string_view name;
  std::span<const std::byte> bytes, whole;
};

WebpChunk next_webp_chunk(ImageCursor& cursor) {
  constexpr std::size_t head_bytes = 8;
  WebpChunk chunk;
  ImageCursor head = cursor;
  chunk.name = {reinterpret_cast<const char*>(head.take(4).data()), 4};
  const std::uint32_t size = head.u32();
  chunk.whole = cursor.take(head_bytes + std::size_t{size});
  chunk.bytes = chunk.whole.subspan(head_bytes);
  if (size % 2 == 1 && cursor.left() > 0) cursor.skip(1);
  return chunk;
}

// A stream must begin with its own signature: libwebp would parse any other beginning as a container.
void set_webp_stream(WebpStream& stream, const WebpChunk& chunk) {
  stream.bytes = chunk.bytes;
  stream.chunk = chunk.whole;
  stream.lossless = chunk.name == "VP8L";
  ImageCursor cursor(chunk.bytes, "WebP");
  if (stream.lossless) {
    if (cursor.u8() != 0x2F) fail_webp("has a stream of an unknown kind");
    const std::uint32_t sizes = cursor.u32();
    stream.columns = (sizes & 0x3FFF) + 1;
    stream.rows = (sizes >> 14 & 0x3FFF) + 1;
  } else {
    const bool is_whole = (cursor.u24() & 1) == 0;
    if (!is_whole || cursor.u24() != 0x2A019D) fail_webp("has a stream of an unknown kind");
    stream.columns = cursor.u16() & 0x3FFF;
    stream.rows = cursor.u16() & 0x3FFF;
  }
}

bool is_webp_stream(const WebpChunk& chunk) { return chunk.name == "VP8 " || chunk.name == "VP8L"; }

// The first picture of an animation.
void set_webp_frame(WebpStream& stream, std::span<const std::byte> frame) {
  ImageCursor cursor(frame, "WebP");
  stream.x = 2 * cursor.u24();
  stream.y = 2 * cursor.u24();
  const std::uint32_t columns = cursor.u24() + 1, rows = cursor.u24() + 1;
  cursor.skip(4);
  WebpChunk chunk = next_webp_chunk(cursor);
  while (!is_webp_stream(chunk)) chunk = next_webp_chunk(cursor);
  set_webp_stream(stream, chunk);
  if (stream.columns != columns || stream.rows != rows)
    fail_webp("has a picture of another size than it says");
}

WebpStream webp_stream(std::span<const std::byte> bytes) {
  ImageCursor file(bytes, "WebP");
  file.skip(4);
  const std::uint32_t size = file.u32();
  ImageCursor cursor(file.take(size), "WebP");
  cursor.skip(4);
  WebpStream stream;
  WebpChunk chunk = next_webp_chunk(cursor);
  if (is_webp_stream(chunk)) {
    set_webp_stream(stream, chunk);
    stream.width = stream.columns;
    stream.height = stream.rows;
  } else {
    if (chunk.name != "VP8X") fail_webp("does not begin with pixels or their size");
    ImageCursor canvas(chunk.bytes, "WebP");
    canvas.skip(4);
    stream.width = canvas.u24() + 1;
    stream.height = canvas.u24() + 1;
    while (stream.bytes.empty()) {
      chunk = next_webp_chunk(cursor);
      if (is_webp_stream(chunk)) {
        set_webp_stream(stream, chunk);
        if (stream.columns != stream.width || stream.rows != stream.height)
          fail_webp("has a picture of another size than it says");
      } else if (chunk.name == "ANIM") {
        ImageCursor options(chunk.bytes, "WebP");
        for (const std::size_t channel : {2, 1, 0})
          stream.background[channel] = static_cast<std::uint8_t>(options.u8());
      } else if (chunk.name == "ANMF") {
        set_webp_frame(stream, chunk.bytes);
      }
    }
  }
  check_image_size(stream.columns, stream.rows);
  check_image_size(stream.width, stream.height);
  if (std::uint64_t{stream.x} + stream.columns > stream.width ||
      std::uint64_t{stream.y} + stream.rows > stream.height)
    fail_webp("has a picture beyond its edges");
  return stream;
}

struct WebpDecoderDeleter {
  void operator()(WebPIDecoder* decoder) const { WebPIDelete(decoder); }
};

bool is_webp(std::span<const std::byte> bytes) {
  const std::string_view text = text_of(bytes);
  return text.size() >= 12 && text.starts_with("RIFF") && text.substr(8, 4) == "WEBP";
}

ImageMemory memory_of_webp(std::span<const std::byte> bytes) {
  const WebpStream stream = webp_stream(bytes);
  const std::uint64_t columns = stream.columns, rows = stream.rows;
  ImageMemory memory{std::uint64_t{3} * stream.width * stream.height, (1 << 20) + 128 * columns};
  // Lossless pixels are unpacked as a whole, of four bytes.
  if (stream.lossless) memory.working_bytes += 4 * columns * rows + bytes_of_webp_codes(stream.bytes);
  return memory;
}

ColorImage decode_color_webp(std::span<const std::byte> bytes, const CancelToken& cancel) {
  cancel.check();
  const WebpStream stream = webp_stream(bytes);
  if (stream.lossless) bytes_of_webp_codes(stream.bytes);  // what has no memory stated is not decoded
  ColorImage image;
  image.width = stream.width;
  image.height = stream.height;
  const std::size_t row_bytes = std::size_t{3} * image.width;
  image.rgb.resize(row_bytes * image.height);
  if (stream.columns < stream.width || stream.rows < stream.height)
    for (std::size_t p = 0; p < image.rgb.size(); p += 3)
      std::copy(stream.background.begin(), stream.background.end(), image.rgb.begin() + p);

  WebPDecoderConfig config;
  if (WebPInitDecoderConfig(&config) == 0) throw std::logic_error("another libwebp than that of the build");
  const std::size_t at = stream.y * row_bytes + std::size_t{3} * stream.x;
  config.output.colorspace = MODE_RGB;
  config.output.is_external_memory = 1;
  config.output.u.RGBA.rgba = image.rgb.data() + at;
  config.output.u.RGBA.stride = static_cast<int>(row_bytes);
  config.output.u.RGBA.size = image.rgb.size() - at;
  const std::unique_ptr<WebPIDecoder, WebpDecoderDeleter> decoder(WebPIDecode(nullptr, 0, &config));
  if (!decoder) throw std::bad_alloc();
  // In parts, between which a run can be stopped. Few, as the codes in front of the pixels are read again
  // with each.
  constexpr std::size_t parts = 16;
  VP8StatusCode status = VP8_STATUS_SUSPENDED;
  for (std::size_t part = 1; part <= parts && status == VP8_STATUS_SUSPENDED; ++part) {
    cancel.check();
    status = WebPIUpdate(decoder.get(), reinterpret_cast<const std::uint8_t*>(stream.chunk.data()),
                         stream.chunk.size() * part / parts);
  }
  if (status == VP8_STATUS_OUT_OF_MEMORY) throw std::bad_alloc();
  if (status == VP8_STATUS_SUSPENDED) fail_webp("ends too early");
  if (status != VP8_STATUS_OK) fail_webp("cannot be decoded");
  return image;
}

}  // namespace

extern const ImageFormat webp_image_format = {"WebP", is_webp, memory_of_webp, decode_color_webp};

}  // namespace meander
