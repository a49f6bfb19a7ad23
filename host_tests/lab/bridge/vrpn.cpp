// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/bridge/vrpn.h"

#include <algorithm>
#include <bit>
#include <iterator>
#include <string_view>

namespace m100::lab::bridge {
namespace {

constexpr std::string_view kCookie = "vrpn: ver. 07.38  0";
constexpr std::string_view kAnyVersion = "vrpn: ver. 07.";
constexpr std::string_view kPose = "vrpn_Tracker Pos_Quat";
constexpr std::size_t kHeaderBytes = 24;
constexpr std::size_t kPoseBytes = 64;
constexpr std::int32_t kSenderName = -1;
constexpr std::int32_t kTypeName = -2;

template <typename Value>
Value big_endian(std::span<const std::byte> bytes, std::size_t at) {
  std::array<std::byte, sizeof(Value)> turned{};
  std::reverse_copy(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                    bytes.begin() + static_cast<std::ptrdiff_t>(at + sizeof(Value)), turned.begin());
  return std::bit_cast<Value>(turned);
}

constexpr std::size_t filled(std::size_t size) { return (size + 7) / 8 * 8; }

}  // namespace

static_assert(std::endian::native == std::endian::little, "big_endian() turns every number");

std::array<std::byte, kVrpnCookieBytes> vrpn_cookie() {
  std::array<std::byte, kVrpnCookieBytes> cookie{};
  std::ranges::transform(kCookie, cookie.begin(), [](char letter) { return static_cast<std::byte>(letter); });
  return cookie;
}

bool VrpnStream::consume(std::span<const std::byte> bytes, const Use& use) {
  waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
  std::span<const std::byte> rest(waiting_);
  if (!has_cookie_ && rest.size() >= kVrpnCookieBytes) {
    has_cookie_ = std::equal(kAnyVersion.begin(), kAnyVersion.end(), rest.begin(),
                             [](char letter, std::byte byte) { return static_cast<std::byte>(letter) == byte; });
    if (!has_cookie_) {
      return false;
    }
    rest = rest.subspan(kVrpnCookieBytes);
  }
  while (has_cookie_ && rest.size() >= kHeaderBytes) {
    const auto length = big_endian<std::int32_t>(rest, 0);
    if (length < static_cast<std::int32_t>(kHeaderBytes) || length > static_cast<std::int32_t>(kMaxBytes - 8)) {
      return false;
    }
    const auto size = static_cast<std::size_t>(length);
    if (rest.size() < filled(size)) {
      break;
    }
    take(rest.first(size), use);
    rest = rest.subspan(filled(size));
  }
  waiting_.erase(waiting_.begin(), waiting_.end() - static_cast<std::ptrdiff_t>(rest.size()));
  return waiting_.size() <= kMaxBytes;
}

void VrpnStream::add_name(std::map<std::int32_t, std::string>& names, std::int32_t number,
                          std::span<const std::byte> body) {
  if (body.size() < sizeof(std::int32_t) || names.size() >= kMaxNames) {
    return;
  }
  const std::span<const std::byte> letters = body.subspan(sizeof(std::int32_t));
  const auto end = std::find(letters.begin(), letters.end(), std::byte{0});
  if (end - letters.begin() >= static_cast<std::ptrdiff_t>(kMaxNameBytes)) {
    return;
  }
  std::string& name = names[number];
  name.clear();
  std::transform(letters.begin(), end, std::back_inserter(name), [](std::byte one) { return static_cast<char>(one); });
}

void VrpnStream::take(std::span<const std::byte> message, const Use& use) {
  ++messages_;
  const auto sender = big_endian<std::int32_t>(message, 12);
  const auto type = big_endian<std::int32_t>(message, 16);
  const std::span<const std::byte> body = message.subspan(kHeaderBytes);
  if (type == kSenderName || type == kTypeName) {
    add_name(type == kSenderName ? senders_ : types_, sender, body);
    return;
  }
  const auto name = types_.find(type);
  if (name == types_.end() || name->second != kPose || body.size() != kPoseBytes) {
    return;
  }
  const auto from = senders_.find(sender);
  const double time_s = big_endian<std::int32_t>(message, 4) + 1e-6 * big_endian<std::int32_t>(message, 8);
  const auto number = [&](std::size_t index) { return big_endian<double>(body, 8 + index * sizeof(double)); };
  const PlainPose pose{.t_s = time_s,
                       .position_m = {number(0), number(1), number(2)},
                       .body_to_world = {number(6), number(3), number(4), number(5)}};
  const bool is_wanted =
      from != senders_.end() && from->second == tracker_ && big_endian<std::int32_t>(body, 0) == sensor_;
  if (is_wanted && fault_of(pose) == link::PoseFault::kNone) {
    use(pose);
  } else {
    ++passed_over_;
  }
}

std::vector<std::string> VrpnStream::senders() const {
  std::vector<std::string> names;
  for (const auto& [number, name] : senders_) {
    names.push_back(name);
  }
  return names;
}

std::string VrpnStream::silence_reason() const {
  const std::vector<std::string> names = senders();
  if (std::ranges::find(names, tracker_) != names.end()) {
    return "the server has the tracker '" + tracker_ + "', but no plausible pose of its sensor " +
           std::to_string(sensor_) + " has arrived";
  }
  std::string out = "the server has no tracker '" + tracker_ + "'; it named ";
  for (const std::string& name : names) {
    out += (name == names.front() ? "'" : ", '") + name + "'";
  }
  return names.empty() ? out + "none" : out;
}

}  // namespace m100::lab::bridge
