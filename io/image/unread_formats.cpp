// Formats of images that are told apart by their first bytes, to say what an image is that is not read.
#include <algorithm>
#include <array>
#include <cctype>

#include "io/image/color_formats.h"
#include "io/utf8.h"

namespace meander {

namespace {

using namespace std::string_view_literals;

struct ImageMark {
  std::string_view mark, name;
};

constexpr std::array<ImageMark, 34> image_marks = {{
    {"\xABKTX 20\xBB\r\n\x1A\n"sv, "a KTX2 file"},
    {"\xABKTX 11\xBB\r\n\x1A\n"sv, "a KTX file"},
    {"sB\x13\x00"sv, "a Basis Universal file"},
    {"DDS "sv, "a DDS file"},
    {"II*\0"sv, "a TIFF file"},
    {"MM\0*"sv, "a TIFF file"},
    {"II+\0"sv, "a BigTIFF file"},
    {"MM\0+"sv, "a BigTIFF file"},
    {"8BPS"sv, "a Photoshop file (PSD)"},
    {"v/1\x01"sv, "an OpenEXR file"},
    {"#?RADIANCE"sv, "a Radiance file (HDR)"},
    {"#?RGBE"sv, "a Radiance file (HDR)"},
    {"\0\0\0\x0CJXL \r\n\x87\n"sv, "a JPEG XL file"},
    {"\xFF\x0A"sv, "a JPEG XL file"},
    {"\0\0\0\x0CjP  \r\n\x87\n"sv, "a JPEG 2000 file"},
    {"\xFF\x4F\xFF\x51"sv, "a JPEG 2000 file"},
    {"\x13\xAB\xA1\x5C"sv, "an ASTC file"},
    {"PVR\x03"sv, "a PVR file"},
    {"VTF\0"sv, "a VTF file"},
    {"qoif"sv, "a QOI file"},
    {"farbfeld"sv, "a farbfeld file"},
    {"\x01\xDA"sv, "an SGI file"},
    {"\x59\xA6\x6A\x95"sv, "a Sun raster file"},
    {"\0\0\x01\0"sv, "an icon (ICO)"},
    {"\0\0\x02\0\x01\0"sv, "a cursor (CUR)"},
    {"FORM"sv, "an IFF file"},
    {"gimp xcf"sv, "a GIMP file (XCF)"},
    {"/* XPM */"sv, "an XPM file"},
    {"%PDF-"sv, "a PDF file"},
    {"%!PS"sv, "a PostScript file"},
    {"PK\x03\x04"sv, "a zip archive"},
    {"\x1F\x8B\x08"sv, "a gzip file"},
    {"\xD7\xCD\xC6\x9A"sv, "a WMF file"},
    {"version https://git-lfs"sv, "a pointer of Git LFS instead of the image"},
}};

bool is_pcx(std::string_view text) {
  return text.size() >= 128 && text[0] == '\x0A' && "\0\2\3\4\5"sv.find(text[1]) != std::string_view::npos &&
         text[2] == 1 && "\1\2\4\x08"sv.find(text[3]) != std::string_view::npos;
}

bool is_netpbm(std::string_view text) {
  return text.size() >= 3 && text[0] == 'P' &&
         ((text[1] >= '1' && text[1] <= '7') || text[1] == 'F' || text[1] == 'f') &&
         std::isspace(static_cast<unsigned char>(text[2])) != 0;
}

// The name of an element near the beginning of a page or drawing.
bool has_early_tag(std::string_view text, std::string_view tag) {
  constexpr std::size_t searched = 1024;
  text = without_byte_order_mark(text);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front())) != 0) text.remove_prefix(1);
  if (!text.starts_with('<')) return false;
  text = text.substr(0, searched);
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
  };
  return std::search(text.begin(), text.end(), tag.begin(), tag.end(), same) != text.end();
}

// Boxes of the ISO base media format begin with their size, and the first one names the kinds that the file
// is.
std::string_view name_of_boxes(std::string_view text) {
  if (text.size() < 12 || text.substr(4, 4) != "ftyp"sv) return {};
  const std::string_view kind = text.substr(8, 4);
  if (kind.starts_with("avi"sv)) return "an AVIF file";
  constexpr std::array heic = {"heic"sv, "heix"sv, "heim"sv, "heis"sv, "hevc"sv, "hevx"sv};
  if (std::find(heic.begin(), heic.end(), kind) != heic.end()) return "a HEIC file";
  if (kind != "mif1"sv && kind != "msf1"sv) return "a video or another file of ISO boxes";
  const auto size = static_cast<unsigned char>(text[3]);
  return text.substr(0, size).find("avif"sv) != std::string_view::npos ? "an AVIF file" : "a HEIC file";
}

}  // namespace

std::string_view unread_image_format(std::span<const std::byte> bytes) {
  const std::string_view text = text_of(bytes);
  for (const ImageMark& mark : image_marks)
    if (text.starts_with(mark.mark)) return mark.name;
  if (const std::string_view name = name_of_boxes(text); !name.empty()) return name;
  if (is_pcx(text)) return "a PCX file";
  if (is_netpbm(text)) return "a Netpbm file";
  if (has_early_tag(text, "<svg")) return "an SVG drawing";
  if (has_early_tag(text, "<html") || has_early_tag(text, "<!doctype html")) return "a page in HTML";
  return {};
}

}  // namespace meander
