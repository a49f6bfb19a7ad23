# SPDX-License-Identifier: BSD-3-Clause
"""Which test programs judge a mutant of which file: first those of its part, then flights that use the part."""
FLIGHTS = ("scenario_ctl", "scenario_flight", "scenario_faults")

# Beginning of the path, programs that judge first, programs that judge the survivors. The first match counts.
AREAS = (
    ("protocol/mavlink/", ("unit_mavlink", "property_mavlink", "golden_mavlink"), ("unit_link", "unit_order_tap")),
    ("protocol/", ("unit_protocol", "property_protocol", "golden_protocol"), ("unit_link", "golden_flight")),
    ("firmware/core/", ("unit_core", "property_core", "golden_core"), ("unit_est", "unit_ctl", "golden_flight")),
    ("firmware/model/", ("unit_model", "golden_model", "unit_sim", "golden_flight"), ("unit_est", "unit_mpc", "golden_mpc")),
    ("firmware/safety/", ("unit_safety", "unit_safety_transitions", "property_safety", "golden_flight"),
     ("unit_link", "scenario_faults", "property_authority")),
    ("firmware/link/", ("unit_link_parts", "unit_link", "property_rate_limiter", "golden_flight"),
     ("property_link", "unit_n1", "scenario_faults")),
    ("firmware/est/", ("unit_est", "golden_flight"), ("property_est",) + FLIGHTS),
    ("firmware/mpc/", ("unit_mpc", "golden_mpc", "golden_flight"), ("unit_gains", "property_mpc", "scenario_ctl")),
    ("firmware/ctl/", ("unit_ctl", "golden_flight", "scenario_ctl"), ("scenario_flight", "scenario_faults")),
    ("firmware/ref/", ("unit_ref", "golden_flight"), ("scenario_ctl", "scenario_flight")),
    ("firmware/vrc/", ("unit_vrc", "golden_flight"), ("unit_link", "scenario_flight")),
    ("firmware/log/", ("unit_log", "unit_logs", "golden_flight"), ("scenario_faults",)),
    ("firmware/sysid/", ("unit_sysid", "golden_flight"), ("scenario_flight",)),
    ("firmware/app/", ("unit_sensor_adapter", "unit_order_tap", "golden_flight"), FLIGHTS),
    ("firmware/companion/files/", ("unit_vehicle_file", "golden_model", "unit_flight_file", "unit_signature_times_file", "unit_toml_text"),
     ("scenario_faults",)),
    ("firmware/companion/ground_station/", ("unit_ground_station",), ("scenario_faults",)),
    ("firmware/companion/backup/", ("unit_backup_process",), ()),
    ("firmware/companion/operator/live_display", ("unit_live_display",), ()),
    ("firmware/companion/fly/start_position", ("unit_start_position",), ()),
    ("firmware/companion/fly/autopilot_task", ("scenario_faults",), ()),
    ("firmware/companion/fly/monitor/release_monitor", ("scenario_faults",), ()),
    ("firmware/companion/fly/flight_sequencer", ("scenario_faults",), ()),
    ("firmware/companion/operator/operator_messages", ("unit_operator_messages",), ("scenario_faults",)),
    ("firmware/companion/record/recorder", ("unit_recorder",), ()),
    ("firmware/companion/preflight/axis_alignment", ("unit_axis_alignment",), ()),
    ("firmware/companion/preflight/probe/line_probe", ("unit_line_probe",), ()),
    ("hal/cortex_m/", ("unit_hal_cortex_m",), ()),
    ("hal/", ("unit_hal",), ("unit_link",)),
)
# Tests that do not judge: they take seconds, and they check gains and the numbers of a table, not the part's code.
UNASKED = {"unit_gains": "Tuning.*:Margins.*:FlownMargins.*:GeneratedTable.*",
           "unit_mpc": "*EveryBit.*:TableFile.IsRefusedAfterAnyBitOfTheVehicleFile*",
           "property_mpc": "SetpointLaw.*"}
# No mutants are drawn from files outside the areas above, which only the installed program m100 runs (scenario.program
# and scenario.authority would judge them, in minutes each), nor from the files below (image, generated numbers).
LEFT_OUT = ("firmware/app/image/", "firmware/mpc/generated/", "firmware/link/release_sequence",
            "hal/cortex_m/exceptions", "hal/cortex_m/mps2", "hal/cortex_m/semihosting", "hal/cortex_m/stack_paint",
            "hal/cortex_m/startup", "hal/linux/watchdog")


def programs_for(file):
    """-> (first, then), or None if no program of the list judges the file."""
    if file.startswith(LEFT_OUT):
        return None
    for beginning, first, then in AREAS:
        if file.startswith(beginning):
            return first, then
    return None
