// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "hal/linux/descriptor.h"
#include "host_tests/lab/bridge/vrpn.h"

namespace m100::lab::bridge {

/// "TRACKER@HOST" or "TRACKER@HOST:PORT", HOST an IPv4 address.
struct VrpnName {
  std::string tracker;
  std::string host;
  std::uint16_t port = 3883;
};
/// @throws InputError
VrpnName vrpn_name(const std::string& text);

/// A connection to a VRPN server: requested by UDP, then opened by the server over TCP. Waits up to ten seconds for the
/// server. @throws InputError: it did not answer, or there is no route to it.
hal::Descriptor connect(const VrpnName& name);
/// Reads the bytes that have arrived. @returns false: the connection has ended, or the server does not speak VRPN.
bool read(const hal::Descriptor& connection, VrpnStream& stream, const VrpnStream::Use& use);

}  // namespace m100::lab::bridge
