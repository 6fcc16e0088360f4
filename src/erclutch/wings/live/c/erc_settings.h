/* The numbers that the loop and the exported controller are set by, each once: how it may be, its name, its unit and its
 * meaning. erc_layout.h makes members of erc_config of them, erc_core.c checks them, live/layout.py reads them; so their
 * form is kept. ABOVE_ZERO, FROM_ZERO and SIGNED are those of the layout. */
ERC_SETTING(FROM_ZERO, theta_wrap)          /* [rad] range of the first encoder, if it starts again at zero; 0: none */
ERC_SETTING(FROM_ZERO, alpha_wrap)          /* [rad] the same of the second */
ERC_SETTING(FROM_ZERO, theta_glitch)        /* [rad/s] a reading further from the predicted speed cannot be; 0: none */
ERC_SETTING(FROM_ZERO, alpha_glitch)        /* [rad/s] the same of the second encoder */
ERC_SETTING(FROM_ZERO, theta_fastest)       /* [rad/s] nothing turns faster; 0: none */
ERC_SETTING(FROM_ZERO, alpha_fastest)       /* [rad/s] the same of the second encoder */
ERC_SETTING(FROM_ZERO, alpha_limit)         /* [rad] the output goes no further from the middle; 0: none */
ERC_SETTING(FROM_ZERO, torque_limit)        /* [N*m] largest torque that device and sensor can give; 0: none */
ERC_SETTING(FROM_ZERO, torque_rate)         /* [N*m/s] its fastest change; 0: none */
ERC_SETTING(FROM_ZERO, torque_band)         /* [N*m] by which a torque may jump off what is observed; 0: not compared */
ERC_SETTING(FROM_ZERO, torque_still)        /* [N*m] of the model's torque that a live sensor shows; 0: none is stuck */
ERC_SETTING(FROM_ZERO, meter_needed)        /* 1: a torque that cannot be stops programs that do not ask for it, too; 2: also one that disagrees with the model */
ERC_SETTING(FROM_ZERO, load_inertia)        /* [kg*m^2] moved by the measured torque (a single device: and the motor) and dry friction alone; 0: not compared */
ERC_SETTING(FROM_ZERO, load_friction)       /* [N*m] that dry friction */
ERC_SETTING(FROM_ZERO, load_drag)           /* [N*m*s/rad] its viscous drag */
ERC_SETTING(FROM_ZERO, load_band)           /* [N*m] by which the measured torque and the motion of that load may disagree */
ERC_SETTING(ABOVE_ZERO, field_limit)        /* largest field */
ERC_SETTING(ABOVE_ZERO, motor_limit)        /* [N*m] largest torque of the motor */
ERC_SETTING(ABOVE_ZERO, rise_rate)          /* [1/s] of the field, as the supply allows */
ERC_SETTING(ABOVE_ZERO, fall_rate)          /* [1/s] the same towards zero */
ERC_SETTING(FROM_ZERO, stroke)              /* [rad] fields that drive the output further out are refused; 0: none */
ERC_SETTING(SIGNED, k_p)                    /* equation (23): field per rad */
ERC_SETTING(SIGNED, k_d)                    /* equation (23): field per rad/s */
ERC_SETTING(SIGNED, torque_p)               /* field per N m of error of the estimate, without stages */
ERC_SETTING(SIGNED, torque_i)               /* field per N m s, without stages */
ERC_SETTING(FROM_ZERO, torque_lead)         /* [s] lead of the reference: dead time and lag from command to torque */
ERC_SETTING(FROM_ZERO, torque_lag)          /* [s] by which the measured torque is later than the estimate */
ERC_SETTING(ABOVE_ZERO, observer_bandwidth) /* [Hz] of what the device gives beyond its model */
ERC_SETTING(FROM_ZERO, integral_rate)       /* [1/s] of the error of the torque; 0: none */
ERC_SETTING(FROM_ZERO, gain_rate)           /* [1/s] forgetting of a clutch's share of its model's torque; 0: not learned */
ERC_SETTING(ABOVE_ZERO, torque_scale)       /* [N*m] from which that share is learned, and a pull that a wall lets go of */
ERC_SETTING(FROM_ZERO, least_slip)          /* [rad/s] below it both sides run at one speed */
ERC_SETTING(FROM_ZERO, drive_inertia)       /* [kg*m^2] of motor and housings */
ERC_SETTING(FROM_ZERO, drive_friction)      /* [N*m] their dry friction */
ERC_SETTING(SIGNED, drive_drag_1)           /* [N*m*s/rad] of clutch 1 on the drive, beside its torque under field */
ERC_SETTING(SIGNED, drive_drag_2)           /* [N*m*s/rad] the same of clutch 2 */
ERC_SETTING(FROM_ZERO, track_bandwidth)     /* [Hz] of tracking by computed torque; 0: equation (23) */
ERC_SETTING(FROM_ZERO, track_integral)      /* [1/s] of its error */
ERC_SETTING(FROM_ZERO, output_inertia)      /* [kg*m^2] of the output and all that turns with it */
ERC_SETTING(FROM_ZERO, output_friction)     /* [N*m] its dry friction */
ERC_SETTING(FROM_ZERO, stiffness)           /* [N*m/rad] of impedance and wall; at most 2 damping / period */
ERC_SETTING(FROM_ZERO, damping)             /* [N*m*s/rad] of impedance and wall */
ERC_SETTING(FROM_ZERO, wall_play)           /* [rad] by which a hand goes back before a wall lets go */
