//! What a C program can get wrong is an error code.

use std::ffi::{CStr, c_void};
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use seatrial_ffi::*;

/// Aligned memory of the caller.
#[repr(align(8))]
struct Memory([u8; SEATRIAL_TRIAL_BYTES]);

impl Memory {
    fn new() -> Box<Self> {
        Box::new(Self([0xa5; SEATRIAL_TRIAL_BYTES]))
    }

    fn address(&mut self) -> *mut c_void {
        self.0.as_mut_ptr().cast()
    }
}

fn filled<V>(fill: impl FnOnce(*mut V) -> SeatrialStatus) -> V {
    let mut value = MaybeUninit::uninit();
    assert_eq!(fill(value.as_mut_ptr()), SeatrialStatus::Ok);
    // SAFETY: filled in, as the status says.
    unsafe { value.assume_init() }
}

fn plan() -> SeatrialPlan {
    filled(|plan| unsafe { seatrial_plan(1.0, 0.05, plan) })
}

fn lean_settings() -> SeatrialFixedRateSettings {
    filled(|settings| unsafe { seatrial_fixed_rate_settings(1.5, 0.05, settings) })
}

fn guarded_settings() -> SeatrialEstimatorSettings {
    filled(|settings| unsafe { seatrial_estimator_settings(1.5, settings) })
}

fn text(pointer: *const std::ffi::c_char, length: usize) -> String {
    // SAFETY: a text of the library and its length.
    let bytes = unsafe { std::slice::from_raw_parts(pointer.cast(), length) };
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn exact_null_pointers() {
    use SeatrialStatus::NullPointer;
    let mut memory = Memory::new();
    let (plan, lean, guarded) = (plan(), lean_settings(), guarded_settings());
    let size = SEATRIAL_TRIAL_BYTES;
    let mut trial = null_mut();
    let mut estimator = null_mut();
    let mut fixed = null_mut();
    unsafe {
        assert_eq!(seatrial_plan(1.0, 0.05, null_mut()), NullPointer);
        assert_eq!(
            seatrial_trial_new(null_mut(), size, &plan, &mut trial, null_mut()),
            NullPointer
        );
        assert_eq!(
            seatrial_trial_new(memory.address(), size, null(), &mut trial, null_mut()),
            NullPointer
        );
        assert_eq!(
            seatrial_trial_new(memory.address(), size, &plan, null_mut(), null_mut()),
            NullPointer
        );
        assert_eq!(
            seatrial_estimator_new(null_mut(), size, &guarded, &mut estimator, null_mut()),
            NullPointer
        );
        assert_eq!(
            seatrial_fixed_rate_new(null_mut(), size, &lean, 0.0, 0.0, &mut fixed, null_mut()),
            NullPointer
        );
        assert_eq!(seatrial_trial_step(null_mut(), null(), null_mut()), NullPointer);
        assert_eq!(seatrial_trial_take_result(null_mut(), null_mut()), NullPointer);
        assert_eq!(seatrial_trial_status(null_mut(), null_mut()), NullPointer);
        assert_eq!(seatrial_trial_finish_training(null_mut()), NullPointer);
        assert_eq!(
            seatrial_trial_abort(null_mut(), SeatrialAbortReason::Operator as u32),
            NullPointer
        );
        assert_eq!(seatrial_estimator_update(null_mut(), 0.0, 0.0, 0.0, null_mut()), NullPointer);
        assert_eq!(seatrial_estimator_estimate(null_mut(), null_mut()), NullPointer);
        assert_eq!(seatrial_fixed_rate_update(null_mut(), 0.0, 0.0), NullPointer);
        assert_eq!(seatrial_heading_gain(null(), 0.7, null_mut()), NullPointer);
        assert_eq!(seatrial_turn(null(), 0.26, 1.0, true, null_mut()), NullPointer);
        assert_eq!(
            seatrial_schedule_lookup(null(), 2, 0, 0.7, false, null_mut(), null_mut()),
            NullPointer
        );
    }
}

#[test]
fn exact_wrong_memory() {
    let mut memory = Memory::new();
    let plan = plan();
    let mut trial = null_mut();
    unsafe {
        let status = seatrial_trial_new(memory.address(), 64, &plan, &mut trial, null_mut());
        assert_eq!(status, SeatrialStatus::WrongSize);
        let odd = memory.address().byte_add(1);
        let size = SEATRIAL_TRIAL_BYTES - 1;
        let status = seatrial_trial_new(odd, size, &plan, &mut trial, null_mut());
        assert_eq!(status, SeatrialStatus::Misaligned);
        assert!(trial.is_null());

        // Memory in which nothing was made, and another kind of object.
        let sample = SeatrialSample {
            time_s: 0.0,
            heading_rad: 0.0,
            rudder_rad: 0.0,
            surge_speed_m_s: f64::NAN,
            depth_m: f64::NAN,
            altitude_m: f64::NAN,
            roll_rad: f64::NAN,
            pitch_rad: f64::NAN,
            yaw_rate_rad_s: f64::NAN,
            north_m: f64::NAN,
            east_m: f64::NAN,
        };
        let mut action = MaybeUninit::uninit();
        let nothing = memory.address().cast();
        let status = seatrial_trial_step(nothing, &sample, action.as_mut_ptr());
        assert_eq!(status, SeatrialStatus::NotMade);
        let mut fixed = null_mut();
        let settings = lean_settings();
        let size = SEATRIAL_TRIAL_BYTES;
        let status = seatrial_fixed_rate_new(
            memory.address(),
            size,
            &settings,
            0.0,
            0.0,
            &mut fixed,
            null_mut(),
        );
        assert_eq!(status, SeatrialStatus::Ok);
        let status = seatrial_trial_step(fixed.cast(), &sample, action.as_mut_ptr());
        assert_eq!(status, SeatrialStatus::NotMade);
        assert_eq!(seatrial_fixed_rate_update(fixed, 0.0, 0.0), SeatrialStatus::Ok);
        assert_eq!(seatrial_fixed_rate_update(fixed, f64::NAN, 0.0), SeatrialStatus::Refused);
        assert_eq!(seatrial_fixed_rate_set_interval(fixed, 10.0), SeatrialStatus::InvalidSetting);
    }
}

#[test]
fn exact_bad_settings_name_the_field() {
    type Spoil = fn(&mut SeatrialPlan);
    let bad: [(Spoil, &str); 8] = [
        (|p| p.speeds = 17, "speeds"),
        (|p| p.speeds = 0, "thrusts"),
        (|p| p.rudder_limit_rad = f64::NAN, "rudder_limit_rad"),
        (|p| p.training.excitation = 4, "excitation"),
        (|p| p.training.amplitude_rad = 2.0, "training.excitation"),
        (|p| p.not_settled = u32::MAX, "not_settled"),
        (|p| p.rudder_sense = 3, "rudder_sense"),
        (|p| p.area_corners = 2, "envelope.area"),
    ];
    let mut memory = Memory::new();
    for (spoil, field) in bad {
        let mut plan = plan();
        spoil(&mut plan);
        let mut trial = null_mut();
        let mut fault = MaybeUninit::<SeatrialFault>::uninit();
        let size = SEATRIAL_TRIAL_BYTES;
        // SAFETY: memory, plan and places of this test.
        let (status, fault) = unsafe {
            let status =
                seatrial_trial_new(memory.address(), size, &plan, &mut trial, fault.as_mut_ptr());
            (status, fault.assume_init())
        };
        assert_eq!(status, SeatrialStatus::InvalidSetting);
        assert_eq!(text(fault.field, fault.field_length), field);
        assert!(!text(fault.requirement, fault.requirement_length).is_empty());
        assert!(trial.is_null());
    }
    let mut settings = guarded_settings();
    settings.method = 2;
    let mut estimator = null_mut();
    let status = unsafe {
        seatrial_estimator_new(
            memory.address(),
            SEATRIAL_TRIAL_BYTES,
            &settings,
            &mut estimator,
            null_mut(),
        )
    };
    assert_eq!(status, SeatrialStatus::InvalidSetting);
}

/// The plan and the settings that C gets and gives back are the core's own.
#[test]
fn exact_defaults_survive_the_crossing() {
    use seatrial_core::{EstimatorSettings, Plan};
    let crossed = Plan::try_from(SeatrialPlan::from(Plan::<f64>::paper())).unwrap();
    assert_eq!(crossed, Plan::paper());
    for settings in [EstimatorSettings::paper(), EstimatorSettings::default()] {
        let crossed = EstimatorSettings::try_from(SeatrialEstimatorSettings::from(settings));
        assert_eq!(crossed, Ok(settings));
    }
}

#[test]
fn exact_models_without_gain_or_turn() {
    let unstable = SeatrialModel { a22_per_s: 0.1, b2_per_s2: 1.0, c0_rad_per_s2: 0.0 };
    let powerless = SeatrialModel { a22_per_s: -1.0, b2_per_s2: 0.0, c0_rad_per_s2: 0.0 };
    let mut gain = SeatrialHeadingGain::default();
    let mut turn = MaybeUninit::uninit();
    for (model, expected) in
        [(unstable, SeatrialStatus::CourseUnstable), (powerless, SeatrialStatus::NoAuthority)]
    {
        unsafe {
            assert_eq!(seatrial_heading_gain(&model, 0.7, &mut gain), expected);
            let status = seatrial_turn(&model, 0.26, 1.0, true, turn.as_mut_ptr());
            assert_eq!(status, expected);
        }
    }
    let point = |thrust| SeatrialSchedulePoint {
        thrust,
        surge_speed_m_s: f64::NAN,
        model: SeatrialModel { a22_per_s: -1.0, ..unstable },
    };
    let points = [point(0.6), point(0.8)];
    let mut at = |thrust, extrapolate, count| unsafe {
        seatrial_schedule_gain(
            points.as_ptr(),
            count,
            SeatrialScheduleKey::Thrust as u32,
            0.7,
            thrust,
            extrapolate,
            &raw mut gain,
            null_mut(),
        )
    };
    assert_eq!(at(0.7, false, 2), SeatrialStatus::Ok);
    assert_eq!(at(0.9, false, 2), SeatrialStatus::OutsideRange);
    assert_eq!(at(0.9, true, 2), SeatrialStatus::Ok);
    assert_eq!(at(0.7, false, 1), SeatrialStatus::InvalidSchedule);
    assert_eq!(at(f64::NAN, false, 2), SeatrialStatus::InvalidSetting);
}

#[test]
fn exact_every_status_has_a_text() {
    let texts: std::collections::HashSet<_> =
        (0..=13).map(|status| unsafe { CStr::from_ptr(seatrial_status_text(status)) }).collect();
    assert_eq!(texts.len(), 14);
    assert_eq!(seatrial_status_text(13), seatrial_status_text(u32::MAX));
}

#[test]
fn exact_another_library_is_refused() {
    let size = size_of::<SeatrialNumber>();
    assert_eq!(seatrial_check_abi(SEATRIAL_ABI, size), SeatrialStatus::Ok);
    for (abi, size) in [(SEATRIAL_ABI + 1, size), (SEATRIAL_ABI, size / 2)] {
        assert_eq!(seatrial_check_abi(abi, size), SeatrialStatus::WrongLibrary);
    }
}
