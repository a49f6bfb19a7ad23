// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/replay/flight_notes.h"

#include <optional>
#include <span>
#include <sstream>
#include <string>

#include "firmware/companion/files/flight_file.h"
#include "firmware/companion/files/text/plain_number.h"

namespace m100::companion {
namespace {

constexpr const char* kPaperLaw = "paper";  // the word of app::FlightConfig::paper_law

[[noreturn]] void refuse_link_note() { throw FlightLogError(std::string("'") + kLinkNote + "' is of another version"); }

/// Reads an entry of the link note that is there only if chosen: a law, a sender of poses or its sigma, or a disabled
/// check.
void read_choice(const std::string& key, const std::string& word, app::FlightConfig& config) {
  const std::optional<mpc::Law> law = key == "law" ? mpc::law_of(word) : std::nullopt;
  const std::optional<est::ConsistencyCheck> off = key == "override" ? est::check_of(word) : std::nullopt;
  if (key == "pose_from") {
    config.pose_from = sender_of(word, kLinkNote);
  } else if (key == "pose_sigma_m" && is_plain_number(word)) {
    config.pose_sigma_m = std::stod(word);
  } else if (key == "law" && word == kPaperLaw) {
    config.paper_law = true;
  } else if (law) {
    config.law = *law;
  } else if (off) {
    config.disabled_checks = static_cast<est::CheckSet>(config.disabled_checks | set_of(*off));
  } else {
    refuse_link_note();
  }
}

}  // namespace

const std::string& note_of(const RecordedFlight& flight, const char* key) {
  const auto found = flight.notes.find(key);
  if (found == flight.notes.end()) {
    throw FlightLogError(std::string("the log does not hold '") + key + "': it cannot be replayed");
  }
  return found->second;
}

bool read_link_note(const std::string& text, app::FlightConfig& config) {
  bool encrypted = false;
  std::istringstream words(text);
  std::string app_id, rate, pose_baud, crypt;
  words >> app_id >> config.link.app_id >> rate >> config.link.channel.rate_hz >> pose_baud >> config.pose_baud >>
      crypt >> encrypted;
  if (!words || app_id != "app_id" || rate != "rate_hz" || pose_baud != "pose_baud" || crypt != "encrypted") {
    refuse_link_note();
  }
  if (std::string baud; words >> baud) {  // for the arrival of frames that one read brings; older logs lack it
    words >> config.link.baud;
    if (!words || baud != "baud") {
      refuse_link_note();
    }
  }
  for (std::string key, word; words >> key;) {
    if (!(words >> word)) {
      refuse_link_note();
    }
    read_choice(key, word, config);
  }
  return encrypted;
}

bool add_table_notes(std::string_view tables, std::vector<log::Note>& notes) {
  for (const char* const key : kTablesNotes) {
    if (!tables.empty()) {
      notes.push_back({key, tables.substr(0, log::kLongestNote_bytes)});
      tables.remove_prefix(notes.back().text.size());
    }
  }
  return tables.empty();
}

std::string tables_of(const RecordedFlight& flight) {
  std::string out = note_of(flight, kTablesNotes.front());
  for (const char* const more : std::span(kTablesNotes).subspan(1)) {
    out += flight.notes.contains(more) ? note_of(flight, more) : "";
  }
  return out;
}

std::string link_note(const app::FlightConfig& config) {
  std::ostringstream text;
  text.precision(17);
  text << "app_id " << config.link.app_id << " rate_hz " << config.link.channel.rate_hz << " pose_baud "
       << config.pose_baud << " encrypted " << (config.link.encrypt_commands ? 1 : 0) << " baud " << config.link.baud;
  if (config.paper_law) {
    text << " law " << kPaperLaw;
  }
  if (config.law != mpc::Law::kMpc) {
    text << " law " << mpc::name(config.law);
  }
  if (config.pose_from.is_made()) {
    text << " pose_from " << +config.pose_from.system;
    if (config.pose_from.component != 0) {
      text << ":" << +config.pose_from.component;
    }
  }
  if (config.pose_sigma_m > 0.0) {
    text << " pose_sigma_m " << config.pose_sigma_m;
  }
  for (std::size_t check = 1; check < est::kCheckCount; ++check) {
    if ((config.disabled_checks & est::set_of(static_cast<est::ConsistencyCheck>(check))) != 0) {
      text << " override " << est::name(static_cast<est::ConsistencyCheck>(check));
    }
  }
  return text.str();
}

}  // namespace m100::companion
