// PNG, JPEG and WebP files that tests make. Programs that use it link libpng, libjpeg or libwebp themselves.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>
// Needs stdio.h in front of it.
#include <jpeglib.h>
#include <webp/encode.h>

#include "support/png_files.h"

namespace meander::test {

// Rows from top to bottom of pixels of three bytes.
struct TestImage {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> rgb;

  TestImage(std::uint32_t columns, std::uint32_t rows,
            const std::function<std::vector<int>(std::uint32_t, std::uint32_t)>& color)
      : width(columns), height(rows) {
    for (std::uint32_t y = 0; y < height; ++y)
      for (std::uint32_t x = 0; x < width; ++x)
        for (const int value : color(x, y)) rgb.push_back(static_cast<std::uint8_t>(value));
  }
};

inline std::string png_bytes(const TestImage& image) {
  return png_bytes({image.width, image.height, 8, PNG_COLOR_TYPE_RGB, false, {}, false},
                   [&](std::size_t x, std::size_t y, std::size_t channel) {
                     return image.rgb[3 * (y * image.width + x) + channel];
                   });
}

struct JpegKind {
  bool progressive = false, gray = false, inks = false;  // inks: CMYK with Adobe's mark, paper 255
};

// Quality 100 without subsampling: within a few of 255. Of gray files the red values, of inks white ink.
inline std::string jpeg_bytes(const TestImage& image, JpegKind kind = {}) {
  jpeg_compress_struct info{};
  jpeg_error_mgr errors{};
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* data = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &data, &size);
  info.image_width = image.width;
  info.image_height = image.height;
  info.input_components = kind.gray ? 1 : kind.inks ? 4 : 3;
  info.in_color_space = kind.gray ? JCS_GRAYSCALE : kind.inks ? JCS_CMYK : JCS_RGB;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, 100, TRUE);
  info.comp_info[0].h_samp_factor = info.comp_info[0].v_samp_factor = 1;
  if (kind.progressive) jpeg_simple_progression(&info);
  jpeg_start_compress(&info, TRUE);
  std::vector<JSAMPLE> row;
  for (std::uint32_t y = 0; y < image.height; ++y) {
    row.clear();
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const std::uint8_t* const pixel = image.rgb.data() + std::size_t{3} * (y * image.width + x);
      row.insert(row.end(), pixel, pixel + (kind.gray ? 1 : 3));
      if (kind.inks) row.push_back(255);
    }
    JSAMPLE* const rows = row.data();
    JSAMPROW of_rows[] = {rows};
    jpeg_write_scanlines(&info, of_rows, 1);
  }
  jpeg_finish_compress(&info);
  std::string bytes(reinterpret_cast<char*>(data), size);
  jpeg_destroy_compress(&info);
  std::free(data);
  return bytes;
}

struct WebpKind {
  float quality = 100;  // of those that lose something
  bool lossless = true;
  bool alpha = false;  // half of it
  int method = 4;      // how long libwebp looks for short codes: 0 .. 6
};

inline std::string webp_bytes(const TestImage& image, WebpKind kind = {}) {
  WebPConfig config;
  WebPPicture picture;
  if (WebPConfigInit(&config) == 0 || WebPPictureInit(&picture) == 0) std::abort();
  config.lossless = kind.lossless ? 1 : 0;
  config.quality = kind.quality;
  config.method = kind.method;
  config.exact = 1;  // transparent pixels keep their colors
  picture.use_argb = 1;
  picture.width = static_cast<int>(image.width);
  picture.height = static_cast<int>(image.height);
  std::vector<std::uint8_t> rgba;
  for (std::size_t p = 0; p < image.rgb.size(); ++p) {
    rgba.push_back(image.rgb[p]);
    if (p % 3 == 2) rgba.push_back(kind.alpha ? 128 : 255);
  }
  WebPMemoryWriter writer;
  WebPMemoryWriterInit(&writer);
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &writer;
  if (WebPPictureImportRGBA(&picture, rgba.data(), 4 * picture.width) == 0 ||
      WebPEncode(&config, &picture) == 0)
    std::abort();
  std::string bytes(reinterpret_cast<const char*>(writer.mem), writer.size);
  WebPPictureFree(&picture);
  WebPMemoryWriterClear(&writer);
  return bytes;
}

}  // namespace meander::test
