// Reading deflated data from front to back, and from access points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/file/byte_source.h"

namespace meander {

// Where decompression can begin in the middle: between two blocks of deflated data.
struct AccessPoint {
  std::uint64_t packed = 0;    // the next byte of the gzip file
  std::uint64_t unpacked = 0;  // how many bytes were unpacked before
  int bits = 0;                // of the byte before, that are not used yet
  std::string window;          // the bytes unpacked last, up to 32 KiB
};

// The access points of one gzip file. The list grows while the file is read for the first time; afterwards it
// is shared by threads.
class AccessPoints {
 public:
  // Whether a point at this place is wanted.
  bool wants(std::uint64_t unpacked) const { return unpacked >= next_; }
  void add(AccessPoint point);
  // The last point at or before the place; null: the beginning of the file.
  const AccessPoint* before(std::uint64_t unpacked) const;
  // Every second point goes, and half as many are made from now on.
  void thin();

  std::uint64_t memory_bytes() const;
  std::uint64_t spacing() const { return spacing_; }

 private:
  std::vector<AccessPoint> points_;  // ascending
  std::uint64_t spacing_ = std::uint64_t{1} << 19, next_ = spacing_;
};

enum class Wrapping : std::uint8_t { gzip, raw };

// The unpacked bytes of a part of a source: gzip files, several behind each other too, or the bare deflated
// data of a zip member. Made for reading forwards: what lies between two reads is unpacked and forgotten, and
// a read behind the last one begins again, at an access point where there are some. Memory: 100 KiB. One
// thread at a time. `bytes` is what bytes() returns.
//
// Every read throws ItemError(unreadable) when the data up to there are damaged or cut, or when more than
// `most` bytes would be unpacked altogether.
class InflateSource final : public ByteSource {
 public:
  struct Part {
    std::uint64_t begin = 0, end = 0;  // of the packed bytes
  };
  InflateSource(const ByteSource& packed, Part part, Wrapping wrapping, std::uint64_t bytes,
                std::uint64_t most = ~std::uint64_t{0});
  ~InflateSource() override;

  // Reads from these points, which must be those of the file and outlive the source.
  void use(const AccessPoints& points);
  // Adds points to these while it reads.
  void record(AccessPoints& points);

  std::uint64_t bytes() const override { return bytes_; }
  std::string read(std::uint64_t offset, std::size_t count) const override;
  // Reads to the end, counting; checks the checksums of gzip. Returns the number of all bytes.
  std::uint64_t count_rest() const;
  // The next bytes; fewer only at the end. What read() does from the place where it stands.
  std::size_t next(std::span<char> bytes) const;

 private:
  class Stream;
  const ByteSource& packed_;
  Part part_;
  Wrapping wrapping_;
  std::uint64_t bytes_, most_;
  const AccessPoints* points_ = nullptr;
  AccessPoints* recorded_ = nullptr;
  mutable std::unique_ptr<Stream> stream_;
};

}  // namespace meander
