// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/app/config.h"
#include "firmware/companion/files/recorded_flight.h"
#include "firmware/log/ulog_writer.h"

// The notes of a log that a replay needs in addition to the records.
namespace m100::companion {

inline constexpr const char* kVehicleNote = "m100_vehicle";  ///< the vehicle file's text
/// The gain table file's bytes, in as many notes as it needs.
inline constexpr std::array kTablesNotes{"m100_tables", "m100_tables_more", "m100_tables_more_2", "m100_tables_more_3",
                                         "m100_tables_more_4"};
inline constexpr const char* kVersionNote = "m100_version";  ///< of the program; a replay ignores it
inline constexpr const char* kCourseNote = "m100_course";    ///< for parse_course(); empty: a hover
inline constexpr const char* kFlightNote =
    "m100_flight";                                     ///< the flight file's text; without: safety::Limits' defaults
inline constexpr const char* kModeNote = "m100_mode";  ///< the tuning that flew
inline constexpr const char* kDryRunNote = "m100_dry_run";   ///< if present: no byte was sent
inline constexpr const char* kStartNote = "m100_start";      ///< "x y z yaw" of the course's start
inline constexpr const char* kChannelNote = "m100_channel";  ///< "virtual_rc" or "movement", then "paper_100_hz" or not
inline constexpr const char* kExcitationNote = "m100_excitation";  ///< excitation_of_note()
inline constexpr const char* kGoalsNote = "m100_goals";  ///< goals_note(); if present: goals over the pose port counted
/// home_note(); without it a low battery has no effect.
inline constexpr const char* kHomeNote = "m100_home";
/// link_note(); a log without it was flown with app id 1, the default rate, the default pose baud, unencrypted.
inline constexpr const char* kLinkNote = "m100_link";

/// The note of that key. @throws FlightLogError the log does not hold it.
const std::string& note_of(const RecordedFlight& flight, const char* key);

/// The other settings on which the sent bytes depend: "app_id N rate_hz X pose_baud N encrypted 0|1 baud N", then "law
/// NAME", "pose_from SYS[:COMP]", "pose_sigma_m X" and "override CHECK" where not the default. It does not hold the
/// key.
std::string link_note(const app::FlightConfig& config);

/// Sets in `config` what link_note() has written, except encryption. @throws FlightLogError the note is malformed or of
/// another version. @returns whether the commands were encrypted.
bool read_link_note(const std::string& text, app::FlightConfig& config);

/// Adds the notes that hold a gain table file. @returns false: it needs more notes than there are.
bool add_table_notes(std::string_view tables, std::vector<log::Note>& notes);

/// The gain table file that a log holds. @throws FlightLogError it holds none.
std::string tables_of(const RecordedFlight& flight);

}  // namespace m100::companion
