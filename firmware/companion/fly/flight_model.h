// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "firmware/companion/files/text_file.h"
#include "firmware/companion/files/vehicle_file.h"
#include "firmware/companion/subcommands.h"
#include "firmware/mpc/table_file.h"

namespace m100::companion {

/// The vehicle and the tables that were made from it; refused if they do not belong together (R10).
class FlightModel {
 public:
  FlightModel(const std::string& vehicle_path, const std::string& tables_path)
      : text_(read_file(vehicle_path)), file_(parse_vehicle(text_, vehicle_path)), bytes_(read_file(tables_path)) {
    switch (storage_->load(std::as_bytes(std::span(bytes_)), file_.digest)) {
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
  const VehicleFile& file() const { return file_; }
  const model::Vehicle& vehicle() const { return file_.vehicle; }
  const mpc::GainTables<double>& tables() const { return storage_->tables(); }
  const std::string& vehicle_text() const { return text_; }
  const std::string& table_bytes() const { return bytes_; }

 private:
  std::string text_;
  VehicleFile file_;
  std::string bytes_;
  std::unique_ptr<mpc::TableStorage<double>> storage_ = std::make_unique<mpc::TableStorage<double>>();
};

}  // namespace m100::companion
