// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/backup/backup_channel.h"

#include <sys/socket.h>
#include <time.h>

#include <cerrno>
#include <cstring>

namespace m100::companion {
namespace {

/// Buffer for the descriptor that may accompany a message. No heap.
union Ancillary {
  cmsghdr header;  ///< for its alignment
  std::array<char, CMSG_SPACE(sizeof(int))> bytes;
};

}  // namespace

core::TimePoint monotonic_now() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return core::TimePoint{} + std::chrono::seconds(now.tv_sec) + std::chrono::microseconds(now.tv_nsec / 1000);
}

bool send_message(int socket, char letter, int descriptor) {
  iovec text{.iov_base = &letter, .iov_len = 1};
  Ancillary ancillary{};
  msghdr message{};
  message.msg_iov = &text;
  message.msg_iovlen = 1;
  if (descriptor >= 0) {
    message.msg_control = ancillary.bytes.data();
    message.msg_controllen = ancillary.bytes.size();
    cmsghdr* const header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof descriptor);
    std::memcpy(CMSG_DATA(header), &descriptor, sizeof descriptor);
  }
  return sendmsg(socket, &message, MSG_DONTWAIT | MSG_NOSIGNAL) == 1;
}

BackupMessage receive_message(int socket) {
  char letter = 0;
  iovec text{.iov_base = &letter, .iov_len = 1};
  Ancillary ancillary{};
  msghdr message{};
  message.msg_iov = &text;
  message.msg_iovlen = 1;
  message.msg_control = ancillary.bytes.data();
  message.msg_controllen = ancillary.bytes.size();
  const ssize_t count = recvmsg(socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (count < 0) {
    return {.letter = errno == EAGAIN || errno == EINTR ? 0 : -1};
  }
  BackupMessage word{.letter = count == 0 ? -1 : letter};
  const cmsghdr* const header = CMSG_FIRSTHDR(&message);
  if (header != nullptr && header->cmsg_type == SCM_RIGHTS && header->cmsg_len == CMSG_LEN(sizeof(int))) {
    std::memcpy(&word.descriptor, CMSG_DATA(header), sizeof word.descriptor);
  }
  return word;
}

}  // namespace m100::companion
