// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/folder.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <sstream>

#include "firmware/core/sha256.h"
#include "host_tests/lab/aliases.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab::evening {
namespace {

constexpr const char* kStateFile = "evening.json";
constexpr const char* kFormat = "m100-evening-1";

Json to_json(const Settings& settings) {
  Json out;
  for_each_setting([&](const char*, const char* key, bool, const auto& member) { out[key] = member(settings); });
  return out;
}

Settings settings_of(const Json& json) {
  Settings out;
  for_each_setting([&](const char*, const char* key, bool is_old, const auto& member) {
    auto& value = member(out);
    value = is_old ? json.at(key).get<std::remove_cvref_t<decltype(value)>>() : json.value(key, value);
  });
  return out;
}

}  // namespace

void check_ports(const Settings& settings) {
  const std::string conflict = settings.port == settings.pose.port
                                   ? "--pose-port: " + settings.pose.port + " is the autopilot's port, too"
                               : !settings.bridge.empty() && settings.pose.key_file.empty()
                                   ? "--bridge: its poses are signed, and need --mavlink-key"
                                   : companion::conflict_of(settings.pose);
  if (!conflict.empty()) {
    throw InputError("evening", 0, "", conflict);
  }
}

std::vector<std::string> bridge_command(const Settings& settings) {
  std::istringstream words(settings.bridge);
  std::vector<std::string> out{std::istream_iterator<std::string>(words), {}};
  if (!out.empty()) {
    const std::string key = std::filesystem::absolute(settings.pose.key_file).string();
    out.insert(out.begin(), {"m100-lab", "bridge", "--mavlink-key", key});
  }
  return out;
}

std::string sha256_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in || !std::filesystem::is_regular_file(path)) {
    return "";
  }
  core::Sha256 hash;
  std::vector<char> piece(1U << 16U);
  while (in.read(piece.data(), static_cast<std::streamsize>(piece.size())) || in.gcount() > 0) {
    hash.update(std::as_bytes(std::span(piece).first(static_cast<std::size_t>(in.gcount()))));
  }
  const std::array<char, 64> digits = core::hex(hash.finish());
  return {digits.begin(), digits.end()};
}

void write_file(const std::string& path, std::string_view bytes) {
  const std::string partial = path + ".partial";
  std::ofstream out(partial, std::ios::binary | std::ios::trunc);
  out << bytes;
  out.close();
  std::error_code error;
  if (out) {
    std::filesystem::rename(partial, path, error);
  }
  if (!out || error) {
    std::filesystem::remove(partial, error);
    throw InputError(path, 0, "", "cannot be written: the disk is full, or the permission is missing");
  }
}

std::string made(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!std::filesystem::is_directory(path)) {
    throw InputError(path, 0, "", "is not a folder and cannot be created" + (error ? ": " + error.message() : ""));
  }
  return path;
}

Folder::Folder(const std::string& path) : path_(made(path)) {
  if (!has(kStateFile)) {
    return;
  }
  try {
    const Json state = with_current_names(Json::parse(whole_file(file(kStateFile))));
    if (state.at("format") != kFormat) {
      throw InputError(file(kStateFile), 0, "format", "is not " + std::string(kFormat));
    }
    settings_ = settings_of(state.at("settings"));
    done_ = state.at("done").get<decltype(done_)>();
    numbers_ = state.at("numbers").get<decltype(numbers_)>();
    for (const auto& [name, made] : state.at("files").items()) {
      files_[name] = {made.at("sha256").get<std::string>(), made.at("made_by").get<std::string>(),
                      made.at("from").get<std::map<std::string, std::string>>()};
    }
  } catch (const JsonError& wrong) {
    throw InputError(file(kStateFile), 0, "",
                     std::string("is not the state of an evening (") + wrong.what() +
                         "); without this file the evening begins anew, with the files that are there");
  }
}

std::string Folder::file(const std::string& name) const { return (std::filesystem::path(path_) / name).string(); }

bool Folder::has(const std::string& name) const { return std::filesystem::exists(file(name)); }

bool Folder::is_done(const std::string& step) const {
  return std::find(done_.begin(), done_.end(), step) != done_.end();
}

void Folder::done(const std::string& step, const std::vector<std::string>& makes,
                  const std::vector<std::string>& reads) {
  for (const std::string& name : makes) {
    MadeFile& made = files_[name] = {sha256_of(file(name)), step, {}};
    for (const std::string& source : reads) {
      made.from[source] = sha256_of(file(source));
    }
  }
  for (const std::string& source : reads) {
    if (!files_.contains(source)) {
      files_[source] = {sha256_of(file(source)), "", {}};  // a person put it there
    }
  }
  if (!is_done(step)) {
    done_.push_back(step);
  }
}

bool Folder::was_taken(const std::string& step, const std::vector<std::string>& makes) const {
  return !makes.empty() && std::all_of(makes.begin(), makes.end(), [&](const std::string& name) {
    const auto found = files_.find(name);
    return found != files_.end() && found->second.made_by == step && found->second.sha256 == sha256_of(file(name));
  });
}

void Folder::put_aside(const std::string& step, const std::vector<std::string>& makes) {
  int number = 1;
  const auto aside = [&] { return std::filesystem::path(file("not_passed")) / (step + "." + std::to_string(number)); };
  while (std::filesystem::exists(aside())) {
    ++number;
  }
  std::filesystem::create_directories(aside());
  for (const std::string& name : makes) {
    std::filesystem::rename(file(name), aside() / name);
    files_.erase(name);
  }
}

void Folder::again(const std::string& step) {
  if (!is_done(step)) {
    return;
  }
  std::erase(done_, step);
  for (const auto& [name, made] : std::map(files_)) {
    if (made.made_by == step) {
      for (const auto& [other, later] : std::map(files_)) {
        if (later.from.contains(name) && later.made_by != step) {
          again(later.made_by);
        }
      }
    }
  }
}

std::string Folder::again_after(const std::string& name, const std::string& sha256) {
  std::string steps;
  for (const auto& [other, made] : std::map(files_)) {
    if (made.from.contains(name) && made.from.at(name) != sha256 && is_done(made.made_by)) {
      steps += (steps.empty() ? "'" : ", '") + made.made_by + "'";
      again(made.made_by);
    }
  }
  return steps;
}

std::vector<std::string> Folder::look_for_changes() {
  std::vector<std::string> said;
  for (auto& [name, made] : files_) {
    const std::string now = sha256_of(file(name));
    if (now == made.sha256) {
      continue;
    }
    const bool was_done = made.made_by.empty() || is_done(made.made_by);
    if (now.empty() && !made.made_by.empty()) {
      if (was_done) {
        said.push_back(name + " is missing: the step '" + made.made_by + "' must be done again");
      }
      again(made.made_by);
      continue;
    }
    made.sha256 = now;
    const std::string later = again_after(name, now);
    if (was_done && !later.empty()) {
      said.push_back(name + " changed after it was used. Steps to do again: " + later +
                     ", and all steps that used their files");
    }
  }
  return said;
}

void Folder::save(const Json& next) const {
  Json made = Json::object();
  for (const auto& [name, one] : files_) {
    made[name] = {{"sha256", one.sha256}, {"made_by", one.made_by}, {"from", one.from}};
  }
  const Json state{{"format", kFormat},   {"settings", to_json(settings_)},
                   {"done", done_},       {"files", made},
                   {"numbers", numbers_}, {"next", next}};
  write_file(file(kStateFile), state.sorted().dump(1) + "\n");
}

}  // namespace m100::lab::evening
