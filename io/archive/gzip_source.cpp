#include "io/archive/gzip_source.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <climits>
#include <new>
#include <utility>

#include "io/archive/archive_member.h"

namespace meander {

namespace {

constexpr std::size_t piece_bytes = std::size_t{1} << 16;
constexpr int window_bits = 15, with_gzip = 16;

}  // namespace

// ---- AccessPoints ----------------------------------------------------------------------------------------

void AccessPoints::add(AccessPoint point) {
  next_ = point.unpacked + spacing_;
  points_.push_back(std::move(point));
}

const AccessPoint* AccessPoints::before(std::uint64_t unpacked) const {
  const auto after =
      std::upper_bound(points_.begin(), points_.end(), unpacked,
                       [](std::uint64_t place, const AccessPoint& point) { return place < point.unpacked; });
  return after == points_.begin() ? nullptr : &*std::prev(after);
}

void AccessPoints::thin() {
  std::vector<AccessPoint> kept;
  for (std::size_t i = 1; i < points_.size(); i += 2) kept.push_back(std::move(points_[i]));
  points_ = std::move(kept);
  spacing_ *= 2;
  next_ = (points_.empty() ? 0 : points_.back().unpacked) + spacing_;
}

std::uint64_t AccessPoints::memory_bytes() const {
  std::uint64_t bytes = 0;
  for (const AccessPoint& point : points_) bytes += sizeof point + point.window.size();
  return bytes;
}

// ---- Stream ----------------------------------------------------------------------------------------------

// One pass over the packed bytes.
class InflateSource::Stream {
 public:
  Stream(const InflateSource& source, const AccessPoint* from)
      : source_(source), next_packed_(source.part_.begin), behind_raw_(false) {
    const bool raw = source.wrapping_ == Wrapping::raw || from != nullptr;
    if (inflateInit2(&z_, raw ? -window_bits : window_bits + with_gzip) != Z_OK) throw std::bad_alloc();
    if (from == nullptr) return;
    behind_raw_ = true;
    position_ = from->unpacked;
    next_packed_ = from->packed;
    if (from->bits > 0) {
      const std::string byte = source.packed_.read(from->packed - 1, 1);
      if (byte.empty()) fail("cut");
      inflatePrime(&z_, from->bits, static_cast<unsigned char>(byte[0]) >> (8 - from->bits));
    }
    inflateSetDictionary(&z_, reinterpret_cast<const Bytef*>(from->window.data()),
                         static_cast<uInt>(from->window.size()));
  }
  ~Stream() { inflateEnd(&z_); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  std::uint64_t position() const { return position_; }

  std::size_t next(std::span<char> out) {
    std::size_t done = 0;
    while (done < out.size() && !ended_) {
      const std::size_t room = std::min<std::size_t>(out.size() - done, INT_MAX);
      z_.next_out = reinterpret_cast<Bytef*>(out.data() + done);
      z_.avail_out = static_cast<uInt>(room);
      if (z_.avail_in == 0) load();
      const bool starved = z_.avail_in == 0;
      const int code = inflate(&z_, source_.recorded_ != nullptr ? Z_BLOCK : Z_NO_FLUSH);
      const std::size_t made = room - z_.avail_out;
      done += made;
      position_ += made;
      if (position_ > source_.most_)
        throw ItemError(Status::unreadable, bomb_reason(source_.part_.end - source_.part_.begin, position_));
      if (code == Z_MEM_ERROR) throw std::bad_alloc();
      if (code == Z_STREAM_END)
        end_member();
      else if (starved && made == 0)
        fail("cut: the packed data end too early");
      else if (code != Z_OK && code != Z_BUF_ERROR)
        fail("damaged: the packed data are not what gzip and zip write");
      else if (source_.recorded_ != nullptr)
        record();
    }
    return done;
  }

 private:
  [[noreturn]] static void fail(const char* what) { throw ItemError(Status::unreadable, what); }

  void load() {
    const std::uint64_t left = source_.part_.end - std::min(source_.part_.end, next_packed_);
    input_ = source_.packed_.read(next_packed_,
                                  static_cast<std::size_t>(std::min<std::uint64_t>(left, piece_bytes)));
    next_packed_ += input_.size();
    z_.next_in = reinterpret_cast<Bytef*>(input_.data());
    z_.avail_in = static_cast<uInt>(input_.size());
  }

  // The next packed byte, -1 at the end.
  int take_byte() {
    if (z_.avail_in == 0) load();
    if (z_.avail_in == 0) return -1;
    --z_.avail_in;
    return *z_.next_in++;
  }

  // One part of a gzip file, or the member of a zip archive, is at its end. What follows a gzip file and is
  // none is padding.
  void end_member() {
    ended_ = true;
    if (source_.wrapping_ == Wrapping::raw) return;
    constexpr int trailer_bytes = 8;
    for (int k = 0; behind_raw_ && k < trailer_bytes; ++k)
      if (take_byte() < 0) fail("cut: the packed data end too early");
    behind_raw_ = false;
    if (z_.avail_in == 0) load();
    constexpr int first_of_gzip = 0x1F;
    if (z_.avail_in == 0 || *z_.next_in != first_of_gzip) return;
    inflateReset2(&z_, window_bits + with_gzip);
    ended_ = false;
  }

  void record() {
    constexpr int between_blocks = 128, last_block = 64, bits = 7;
    if ((z_.data_type & between_blocks) == 0 || (z_.data_type & last_block) != 0) return;
    if (!source_.recorded_->wants(position_)) return;
    AccessPoint point;
    point.packed = next_packed_ - z_.avail_in;
    point.unpacked = position_;
    point.bits = z_.data_type & bits;
    uInt length = 1 << window_bits;
    point.window.resize(length);
    inflateGetDictionary(&z_, reinterpret_cast<Bytef*>(point.window.data()), &length);
    point.window.resize(length);
    point.window.shrink_to_fit();
    source_.recorded_->add(std::move(point));
  }

  const InflateSource& source_;
  z_stream z_{};
  std::string input_;
  std::uint64_t next_packed_;  // of the source, behind what is in input_
  std::uint64_t position_ = 0;
  bool behind_raw_;  // began at an access point: the trailer of gzip is not known to zlib
  bool ended_ = false;
};

// ---- InflateSource ---------------------------------------------------------------------------------------

InflateSource::InflateSource(const ByteSource& packed, Part part, Wrapping wrapping, std::uint64_t bytes,
                             std::uint64_t most)
    : packed_(packed), part_(part), wrapping_(wrapping), bytes_(bytes), most_(most) {}

InflateSource::~InflateSource() = default;

void InflateSource::use(const AccessPoints& points) { points_ = &points; }

void InflateSource::record(AccessPoints& points) { recorded_ = &points; }

std::size_t InflateSource::next(std::span<char> bytes) const {
  if (!stream_) stream_ = std::make_unique<Stream>(*this, nullptr);
  return stream_->next(bytes);
}

std::string InflateSource::read(std::uint64_t offset, std::size_t count) const {
  const AccessPoint* const point = points_ == nullptr ? nullptr : points_->before(offset);
  if (!stream_ || offset < stream_->position() || (point != nullptr && point->unpacked > stream_->position()))
    stream_ = std::make_unique<Stream>(*this, point);
  std::array<char, piece_bytes> skipped;
  while (stream_->position() < offset) {
    const std::size_t step = std::min<std::uint64_t>(offset - stream_->position(), skipped.size());
    if (stream_->next(std::span(skipped).first(step)) < step) return {};
  }
  std::string bytes(count, '\0');
  bytes.resize(stream_->next(bytes));
  return bytes;
}

std::uint64_t InflateSource::count_rest() const {
  std::array<char, piece_bytes> skipped;
  while (next(skipped) == skipped.size()) {
  }
  return stream_->position();
}

}  // namespace meander
