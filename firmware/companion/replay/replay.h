// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/app/config.h"
#include "firmware/companion/files/recorded_flight.h"
#include "firmware/core/sha256.h"
#include "firmware/log/ulog_writer.h"
#include "protocol/cipher.h"

namespace m100::app {
template <typename T, typename S>
class FlightController;
}  // namespace m100::app

namespace m100::companion {

/// Which arithmetic the flight code is run in.
enum class Scalar : std::uint8_t { kDouble, kFloat, kFixed };

struct ReplayResult {
  core::Sha256Digest digest{};  ///< over the output bytes and the state record of every tick, in order
  std::size_t ticks = 0;
  std::size_t different_ticks = 0;       ///< ticks whose record or output bytes differ from the log
  std::size_t first_difference = 0;      ///< the first such tick
  std::vector<std::size_t> differences;  ///< all of them
  double largest_difference_m = 0.0;     ///< of the estimated position, against the record
  double largest_command_difference_rad = 0.0;
  std::uint32_t messages_missing = 0;  ///< dropped by the log's ring: their bytes cannot be replayed
};

// The notes of a log that a replay needs beside the records.

inline constexpr const char* kVehicleNote = "m100_vehicle";  ///< the vehicle file's text
/// The gain table file's bytes, in as many notes as it needs.
inline constexpr std::array kTablesNotes{"m100_tables", "m100_tables_more", "m100_tables_more_2", "m100_tables_more_3",
                                         "m100_tables_more_4"};
inline constexpr const char* kVersionNote = "m100_version";  ///< of the program; a replay ignores it
inline constexpr const char* kCourseNote = "m100_course";    ///< parse_course
inline constexpr const char* kFlightNote =
    "m100_flight";                                     ///< the flight file's text; without: safety::Limits' defaults
inline constexpr const char* kModeNote = "m100_mode";  ///< the tuning that flew
inline constexpr const char* kDryRunNote = "m100_dry_run";   ///< if present: no byte was sent
inline constexpr const char* kStartNote = "m100_start";      ///< "x y z yaw" of the course's start
inline constexpr const char* kChannelNote = "m100_channel";  ///< "virtual_rc" or "movement", then "paper_100_hz" or not
inline constexpr const char* kExcitationNote = "m100_excitation";  ///< excitation_of_note()
inline constexpr const char* kGoalsNote = "m100_goals";  ///< goals_note(); if present: goals over the pose port counted
/// home_note(); if present: a low battery ended the flight where it began.
inline constexpr const char* kHomeNote = "m100_home";
/// link_note(); a log without it was flown with app id 1, the default rate, the default pose baud, unencrypted.
inline constexpr const char* kLinkNote = "m100_link";

/// The other settings that determine the bytes sent: "app_id N rate_hz X pose_baud N encrypted 0|1 baud N", then "law
/// NAME" and "override CHECK" where they differ from the default. The key of an encrypted flight is not in it.
std::string link_note(const app::FlightConfig& config);

/// Feeds the recorded bytes, at the recorded times, through the flight code. Errors: FlightLogError.
/// @param cipher of the app's key, for a flight with encrypted commands; otherwise null.
ReplayResult replay(const RecordedFlight& flight, Scalar scalar, const protocol::Cipher* cipher = nullptr);
/// The same in double, as `m100 fly` flew.
/// @param observe called after every tick with the controller, for values that the log does not hold.
ReplayResult replay(const RecordedFlight& flight, const protocol::Cipher* cipher,
                    const std::function<void(const app::FlightController<double, double>&)>& observe);

/// Adds the notes that hold a gain table file. @returns false: it needs more notes than there are.
bool add_table_notes(std::string_view tables, std::vector<log::Note>& notes);

/// The gain table file that a log holds. @throws FlightLogError it holds none.
std::string tables_of(const RecordedFlight& flight);

}  // namespace m100::companion
