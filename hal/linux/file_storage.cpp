// SPDX-License-Identifier: BSD-3-Clause
#include "hal/linux/file_storage.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace m100::hal {

FileStorage::FileStorage(std::string path, const SystemCalls& calls) : path_(std::move(path)), calls_(&calls) {}

core::Status FileStorage::open() {
  if (descriptor_.number >= 0) {
    return core::Status::kOk;
  }
  descriptor_ = Descriptor(::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644));
  if (descriptor_.number >= 0) {
    return core::Status::kOk;
  }
  last_error_ = errno;
  return errno == EEXIST || errno == EACCES || errno == EROFS ? core::Status::kRefused : core::Status::kUnavailable;
}

core::Expected<std::size_t> FileStorage::append(std::span<const std::byte> source) {
  if (descriptor_.number < 0) {
    return core::Status::kUnavailable;
  }
  const ssize_t count = calls_->write(descriptor_.number, source.data(), source.size());
  if (count >= 0) {
    return static_cast<std::size_t>(count);
  }
  if (errno == EINTR || errno == EAGAIN) {
    return std::size_t{0};
  }
  last_error_ = errno;
  return errno == ENOSPC || errno == EDQUOT ? core::Status::kResourceExhausted : core::Status::kUnavailable;
}

core::Status FileStorage::sync() {
  if (descriptor_.number >= 0 && fdatasync(descriptor_.number) == 0) {
    return core::Status::kOk;
  }
  last_error_ = descriptor_.number >= 0 ? errno : EBADF;
  return core::Status::kUnavailable;
}

}  // namespace m100::hal
