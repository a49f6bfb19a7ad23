// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/pose/signed_line.h"

#include <algorithm>

namespace m100::link {
namespace {

constexpr core::Duration kLate = 2 * core::kTickPeriod;
/// Rounds of read(), more than a late tick needs: each uses up a read, a verification, or a part of a chunk.
constexpr std::uint32_t kMaxRounds =
    SignedLine::kLateFactor * (3 * SignedLine::kReadsPerTick + SignedLine::kVerificationsPerTick);

}  // namespace

void SignedLine::tick(core::TimePoint now, mavlink::SignatureTime time) {
  if (ticked_ && (reads_left_ == 0 || verifications_left_ == 0)) {
    ++stats_.interrupted;
  }
  const std::uint32_t factor = ticked_ && now - last_tick_ > kLate ? kLateFactor : 1;
  reads_left_ = factor * kReadsPerTick;
  verifications_left_ = factor * kVerificationsPerTick;
  ticked_ = true;
  last_tick_ = now;
  time_ = time;
}

bool SignedLine::accepts(const mavlink::FrameView& frame) {
  if (!frame.is_signed) {
    ++stats_.unsigned_frames;
    return false;
  }
  if (!is_signed_with(frame, key_)) {
    ++stats_.wrong;
    return false;
  }
  const mavlink::SignatureView signature = mavlink::signature_of(frame);
  switch (guard_.accept(frame.from, signature, time_)) {
    case core::Status::kOk:
      ++stats_.accepted;
      return true;
    case core::Status::kRefused:
      ++stats_.replayed;
      return false;
    case core::Status::kTimeout:
      ++stats_.old;
      stats_.old_by = guard_.newest() - signature.time;
      return false;
    default:
      ++stats_.too_many;
      return false;
  }
}

core::Expected<std::size_t> SignedLine::fill() {
  if (unread_.empty()) {
    if (reads_left_ == 0) {
      return std::size_t{0};
    }
    --reads_left_;
    const core::Expected<std::size_t> count = line_.read(chunk_);
    if (!count || *count == 0) {
      reads_left_ += count ? 1U : 0U;  // an empty line has not used up anything
      return count;
    }
    if (packets_ != nullptr && packets_->begins_packet()) {
      parser_.begin_packet();  // an incomplete frame in another sender's packet must not swallow the next packet
    }
    unread_ = std::span<const std::byte>(chunk_).first(*count);
  }
  const std::size_t taken = parser_.push(unread_);
  unread_ = unread_.subspan(taken);
  return taken;
}

core::Expected<std::size_t> SignedLine::read(std::span<std::byte> destination) {
  for (std::uint32_t round = 0; granted_.empty() && round < kMaxRounds && verifications_left_ > 0; ++round) {
    if (const core::Expected<mavlink::FrameView> frame = parser_.poll()) {
      --verifications_left_;
      if (accepts(*frame)) {
        granted_ = frame->bytes;
        if (packets_ != nullptr) {
          packets_->answer_last();
        }
      }
      continue;
    }
    const core::Expected<std::size_t> came = fill();
    if (!came || *came == 0) {
      return came;
    }
  }
  const std::span<const std::byte> now = granted_.first(std::min(granted_.size(), destination.size()));
  std::copy(now.begin(), now.end(), destination.begin());
  granted_ = granted_.subspan(now.size());
  return now.size();
}

core::Expected<std::size_t> SignedLine::write(std::span<const std::byte> source) {
  mavlink::Frame frame;
  const std::size_t most = frame.space.size() - mavlink::kSignatureBytes;
  if (source.size() < mavlink::kHeader2Bytes + mavlink::kCrcBytes || source.size() > most ||
      source.front() != mavlink::kStart2) {
    return core::Status::kInvalidArgument;
  }
  std::copy(source.begin(), source.end(), frame.space.begin());
  frame.size = source.size();
  last_signed_ = std::max(min_time(), last_signed_ + 1);
  mavlink::sign(frame, key_, link_, last_signed_);
  const core::Expected<std::size_t> sent = line_.write(frame.bytes());
  return sent && *sent == frame.size ? source.size() : sent;
}

}  // namespace m100::link
