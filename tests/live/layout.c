/* Prints sizes and offsets of what crosses a border, for comparison with the dtypes in Python. */
#include "erc_layout.h"

#include <stddef.h>
#include <stdio.h>

#define SIZE(type) printf(#type " sizeof %zu\n", sizeof(type))
#define AT(type, member) printf(#type " " #member " %zu\n", offsetof(type, member))

int main(void) {
    SIZE(erc_frame);
    AT(erc_frame, seq); AT(erc_frame, time_ns); AT(erc_frame, theta); AT(erc_frame, alpha); AT(erc_frame, theta_dot);
    AT(erc_frame, alpha_dot); AT(erc_frame, field1); AT(erc_frame, field2); AT(erc_frame, motor_torque);
    AT(erc_frame, torque); AT(erc_frame, estimate); AT(erc_frame, reference); AT(erc_frame, flags);
    AT(erc_frame, events); AT(erc_frame, lateness_ns); AT(erc_frame, step_ns);
    SIZE(erc_ring_header);
    AT(erc_ring_header, magic); AT(erc_ring_header, version); AT(erc_ring_header, frame_size);
    AT(erc_ring_header, capacity); AT(erc_ring_header, period_ns); AT(erc_ring_header, start_ns);
    AT(erc_ring_header, start_unix_ns); AT(erc_ring_header, rig); AT(erc_ring_header, origin);
    AT(erc_ring_header, model); AT(erc_ring_header, digest); AT(erc_ring_header, note);
    AT(erc_ring_header, field_limit); AT(erc_ring_header, motor_limit); AT(erc_ring_header, head);
    AT(erc_ring_header, state); AT(erc_ring_header, pid); AT(erc_ring_header, mode); AT(erc_ring_header, program);
    AT(erc_ring_header, trip_reason); AT(erc_ring_header, counts); AT(erc_ring_header, sensor_seq);
    AT(erc_ring_header, realtime);
    SIZE(erc_sample);
    AT(erc_sample, seq); AT(erc_sample, time_ns); AT(erc_sample, theta); AT(erc_sample, alpha);
    AT(erc_sample, torque); AT(erc_sample, status);
    SIZE(erc_command);
    AT(erc_command, seq); AT(erc_command, time_ns); AT(erc_command, field1); AT(erc_command, field2);
    AT(erc_command, motor_torque); AT(erc_command, flags);
    SIZE(erc_program);
    AT(erc_program, mode); AT(erc_program, shape); AT(erc_program, flags); AT(erc_program, amplitude);
    AT(erc_program, frequency); AT(erc_program, offset); AT(erc_program, motor_torque); AT(erc_program, soft);
    AT(erc_program, first); AT(erc_program, rows);
    SIZE(erc_config);
    AT(erc_config, magic); AT(erc_config, version); AT(erc_config, size); AT(erc_config, device);
    AT(erc_config, period_ns); AT(erc_config, theta_wrap); AT(erc_config, alpha_wrap); AT(erc_config, filter_g);
    AT(erc_config, filter_h); AT(erc_config, theta_glitch); AT(erc_config, alpha_glitch);
    AT(erc_config, field_limit); AT(erc_config, motor_limit); AT(erc_config, rise_rate); AT(erc_config, fall_rate);
    AT(erc_config, stroke); AT(erc_config, k_p); AT(erc_config, k_d); AT(erc_config, torque_p);
    AT(erc_config, torque_i); AT(erc_config, late_trip_ns); AT(erc_config, hold_samples);
    AT(erc_config, trip_samples); AT(erc_config, programs); AT(erc_config, program); AT(erc_config, list);
    AT(erc_config, crc);
    printf("events %u\n", (unsigned)ERC_GUARD);
    return 0;
}
