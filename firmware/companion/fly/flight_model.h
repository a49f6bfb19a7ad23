// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <string>

#include "firmware/companion/files/mode.h"
#include "firmware/companion/files/text/text_file.h"
#include "firmware/companion/files/vehicle_file.h"
#include "firmware/companion/subcommands.h"
#include "firmware/mpc/table_file.h"

namespace m100::companion {

/// The vehicle and the tables made from it, as they fly in one mode. Errors: UsageError, if they do not belong together
/// (R10). A gain table file holds the tables of the modes one after the other, in the order of kModes. Every table must
/// be intact and made from this vehicle file, also those that do not fly.
class FlightModel {
 public:
  FlightModel(const std::string& vehicle_path, const std::string& tables_path, Mode mode) {
    const std::string text = read_file(vehicle_path);
    const std::string all = read_file(tables_path);
    std::string_view left = all;
    for (const Mode stored : kModes) {
      if (stored != Mode::kField && left.empty()) {  // made before there was this mode
        break;
      }
      if (stored != mode && !has_mode(parse_vehicle(text, vehicle_path), stored)) {
        continue;
      }
      const std::string stored_text = text_in_mode(text, vehicle_path, stored);
      const VehicleFile stored_file = parse_vehicle(stored_text, vehicle_path);
      const std::string_view bytes = left.substr(0, left.find(kBegins, kBegins.size()));
      left.remove_prefix(bytes.size());
      load(bytes, stored_file, vehicle_path, tables_path);
      if (stored == mode) {
        text_ = stored_text;
        file_ = stored_file;
        bytes_ = bytes;
      }
    }
    if (bytes_.empty() || !left.empty()) {
      throw UsageError(tables_path + (left.empty() ? ": has no table of mode " + std::string(name(mode)) +
                                                         "; make it again with m100-lab gains"
                                                   : ": not a gain table file"));
    }
    load(bytes_, file_, vehicle_path, tables_path);
  }
  const VehicleFile& file() const { return file_; }
  const model::Vehicle& vehicle() const { return file_.vehicle; }
  const mpc::GainTables<double>& tables() const { return storage_->tables(); }
  const std::string& vehicle_text() const { return text_; }
  const std::string& table_bytes() const { return bytes_; }

 private:
  static constexpr std::string_view kBegins{mpc::kTableFileMagic.data(), mpc::kTableFileMagic.size()};

  void load(std::string_view bytes, const VehicleFile& file, const std::string& vehicle_path,
            const std::string& tables_path) {
    switch (storage_->load(std::as_bytes(std::span(bytes)), file.digest)) {
      case core::Status::kOk:
        return;
      case core::Status::kRefused:
        throw UsageError(tables_path + ": made from another vehicle file than " + vehicle_path +
                         "; make it again with m100-lab gains");
      case core::Status::kDataLoss:
        throw UsageError(tables_path + ": damaged; make it again with m100-lab gains");
      default:
        throw UsageError(tables_path + ": not a gain table file");
    }
  }

  std::string text_;   ///< of the vehicle file that flies in the mode
  VehicleFile file_;   ///< text_, parsed
  std::string bytes_;  ///< of the table that flies
  std::unique_ptr<mpc::TableStorage<double>> storage_ = std::make_unique<mpc::TableStorage<double>>();
};

}  // namespace m100::companion
