/* SPDX-License-Identifier: BSD-3-Clause
 * Model of promises R4 and R15 (the pilot gets the sticks back): both safety tables as they fly (tables.pml, generated), the code
 * around them (authority.cpp, flight_controller.cpp, supervisor.cpp), an autopilot, a line, an operator, a pilot, and the backup process,
 * which sends releases after the death of the program. A step is 250 ms; at most one unusual event happens in each.
 * check.sh checks it with VIRTUAL_RC 1 and 0.
 */
#include "tables.pml"

#define hbit(set, n) (((set) >> (n)) & 1)
#define WELL (line_in && line_out)
#define HEARD_FOR 2    /* 500 ms */
#define UNUSED_TIME 4  /* FlightController's kUnusedControl, 800 ms, rounded up */
#define HANG_TIME 3    /* BackupProcess::kHang, 700 ms, rounded up */
#define ROUNDS 4       /* BackupProcess::kRounds, 500 ms apart */
#define RELEASED_WITHIN 5 /* R15: 1.0 s, plus the step in which the time begins */
#define DEATH_WITHIN 6 /* R15: 1.5 s */
#define BLIND_WITHIN (COAST_TIME + LEVEL_MOVING_TIME + NEUTRAL_TIME + RELEASED_WITHIN + 3) /* one more step for entering each state */

/* The autopilot (protocol, sections 6.1, 7 and 11). */
bit f = 1; bit ours; bit other; bit virtual_rc; bit asked_once; bit release_once;
/* The line, and the last values of telemetry. */
bit line_in = 1; bit line_out = 1;
byte silent; bit seen_f = 1; bit seen_ours; bit seen_virtual_rc;
/* The program: AuthorityState, the failsafe, the order to fly. */
bit alive = 1;
byte stage = stage_ready; bit asked; byte requests; byte switches; bit owed; bit must_release;
byte since_entry; byte since_request = SPACING; byte since_switch = SPACING;
byte failsafe_state = failsafe_silent; byte failsafe_age; bit order; bit release_next; byte unused; bit pose = 1; bit fast;
bit task;  /* AutopilotTask: the autopilot takes off or lands on the operator's order */
mtype = { no_answer_yet, is_done, is_again, is_refused };
mtype answer = no_answer_yet;
/* The backup process. */
byte dead_for; byte rounds;
byte event;  /* the event of this step */
/* State of the assertions in examine(). */
bit lost; byte since_obtain = SPACING; byte obtains; byte held; byte blind; byte dead_held;

/* Values of one step only. */
hidden int conditions; hidden byte row; hidden byte to; hidden byte action; hidden byte ends_ask; hidden byte push;
hidden byte wants; hidden byte hears; hidden byte shows; hidden byte leaves; hidden byte before; hidden int failsafe_conditions;

inline lose() { push = ours; ours = 0; virtual_rc = 0; asked_once = 0; release_once = 0 }

inline receive_release() {
  virtual_rc = 0;
  if
  :: ours -> release_once = !release_once; ours = release_once
  :: else
  fi
}

inline program_step() {
  since_request = (since_request < SPACING -> since_request + 1 : SPACING);
  since_switch = (since_switch < SPACING -> since_switch + 1 : SPACING);
  since_entry = (since_entry < CONFIRM_TIME -> since_entry + 1 : CONFIRM_TIME);
  shows = seen_ours || seen_virtual_rc;
  hears = silent <= HEARD_FOR;
  owed = shows || (owed && !(hears && !must_release && since_request >= GRANT_TIME && since_switch >= GRANT_TIME));
  if
  :: (conditions & A_ASKED) && !hbit(ACQUIRING_STAGES | HOLDING_STAGES, stage) -> asked = 1; requests = 0; switches = 0
  :: else
  fi;
  asked = asked && !(conditions & A_RELEASE_ASKED);
  conditions = (conditions & ~A_ASKED) | (asked -> A_ASKED : 0) | (hears -> A_HEARD | A_ITEMS_FRESH : 0) |
    (seen_f -> A_MODE_F : 0) | (seen_ours -> A_DEVICE_OURS : 0) | (seen_virtual_rc -> A_VIRTUAL_RC_ON : 0) |
    (VIRTUAL_RC -> A_NEEDS_VIRTUAL_RC : 0) | (since_request >= SPACING -> A_SPACED : 0) |
    (requests < REQUESTS_PER_ACTION -> A_TRIES_LEFT : 0) | (since_switch >= SPACING -> A_SWITCH_SPACED : 0) |
    (switches < REQUESTS_PER_ACTION -> A_SWITCHES_LEFT : 0) | (since_entry >= CONFIRM_TIME -> A_TIME_OVER : 0) |
    (owed -> A_OWED : 0);
  action = ACT_NONE; ends_ask = 0; to = stage;
  match_authority();
  if
  :: row != 255 ->
     since_entry = (to == stage -> since_entry : 0);
     stage = to;
     asked = asked && !(ends_ask || to == stage_obtaining || to == stage_releasing || to == stage_silent || to == stage_silent_cold);
     must_release = must_release || action == ACT_RELEASE;
     answer = no_answer_yet
  :: else
  fi;
  /* A request of start-up delays a release by one step of the program; a step of this model has 25 of them. */
  action = (action == ACT_REQUEST || action == ACT_SWITCH_ON -> action : ACT_NONE);
  wants = hbit(ACQUIRING_STAGES, stage) || stage == stage_in_control;
  if
  :: action == ACT_NONE && !wants && (must_release || shows || (owed && !hears)) -> action = ACT_RELEASE
  :: else
  fi;
  /* What the program sends, and how the autopilot reacts. */
  if
  :: action == ACT_REQUEST ->
     assert(since_obtain >= SPACING);            /* R4: two seconds apart */
     assert(obtains < REQUESTS_PER_ACTION);      /* R4: three per action of the operator */
     since_obtain = 0; obtains++;
     requests++; owed = 1; since_request = 0;
     if
     :: line_out && f && !other ->
        if
        :: !ours -> asked_once = !asked_once; ours = !asked_once
        :: else
        fi;
        release_once = 0;
        answer = (ours -> is_done : is_again)
     :: line_out && f && other -> answer = is_again
     :: line_out && !f -> answer = is_refused
     :: else
     fi
  :: action == ACT_SWITCH_ON ->
     switches++; owed = 1; since_switch = 0;
     virtual_rc = virtual_rc || (line_out && f)
  :: action == ACT_RELEASE ->
     must_release = 0;
     if
     :: line_out -> receive_release()
     :: else
     fi
  :: else
  fi;
  /* Resets counts that no row of the stage reads, to have fewer states. */
  since_entry = (stage == stage_confirming || stage == stage_enabling || stage == stage_listening || stage == stage_pausing ||
                 stage == stage_awaiting_telemetry -> since_entry : 0)
}

inline ladder_step() {
  failsafe_conditions = failsafe_conditions | (stage == stage_in_control && seen_f -> L_COMMANDABLE : 0) |
    (silent > HEARD_FOR -> L_TELEMETRY_DEAD : 0) | (pose && silent == 0 -> L_FRESH | L_RECOVERED : 0) |
    (failsafe_state == failsafe_coast && failsafe_age >= COAST_TIME -> L_COAST_OVER : 0) |
    (failsafe_state == failsafe_level && failsafe_age >= LEVEL_TIME && (!fast || (failsafe_age >= LEVEL_MOVING_TIME && !pose)) -> L_LEVEL_OVER : 0) |
    (failsafe_state == failsafe_release && failsafe_age >= NEUTRAL_TIME -> L_NEUTRAL_OVER : 0) | (order -> L_OPERATOR_ENGAGES : 0) | (task -> L_TASK_FLIES : 0);
  failsafe_age = (failsafe_state == failsafe_level && task -> 0 : failsafe_age);  /* the time of LEVEL begins after the task */
  conditions = failsafe_conditions;
  before = failsafe_state;
  match_failsafe();
  if
  :: row != 255 -> failsafe_state = to; failsafe_age = 0
  :: else
  fi;
  assert(!((failsafe_conditions & L_FAILURE) && failsafe_state != failsafe_silent));  /* R18: an aircraft out of control is the pilot's at once */
  assert(!((failsafe_conditions & L_ON_GROUND) && !task && failsafe_state != failsafe_silent && failsafe_state != failsafe_release));  /* R18: and on the ground */
  failsafe_age = (failsafe_state == failsafe_silent || failsafe_state == failsafe_nominal -> 0 : (failsafe_age < LEVEL_MOVING_TIME -> failsafe_age + 1 : LEVEL_MOVING_TIME));
  fast = fast && failsafe_state == failsafe_level;
  order = order && failsafe_state != failsafe_nominal;
  release_next = before != failsafe_silent && failsafe_state == failsafe_silent && (failsafe_conditions & L_COMMANDABLE);
  unused = (stage == stage_in_control && failsafe_state == failsafe_silent -> (unused < UNUSED_TIME -> unused + 1 : UNUSED_TIME) : 0);
  release_next = release_next || unused == UNUSED_TIME;
  task = task && (hbit(ACQUIRING_STAGES, stage) || stage == stage_in_control)  /* FlightSequencer notices the loss of control */
}

inline examine() {
  leaves = alive && stage == stage_in_control && failsafe_state != failsafe_silent;
  assert(!(leaves && lost));                     /* R4: no control byte after loss */
  held = (alive && ours && !wants && WELL && !push -> held + 1 : 0);
  assert(held <= RELEASED_WITHIN);               /* R15: control that the program does not want is given back */
  blind = (alive && ours && stage == stage_in_control && !pose && !task && WELL -> blind + 1 : 0);  /* a task needs no pose */
  assert(blind <= BLIND_WITHIN);                 /* without a pose, the failsafe hands over to the pilot */
  dead_held = (!alive && ours && WELL && (rounds > 0 || dead_held > 0) -> dead_held + 1 : 0);
  assert(dead_held <= DEATH_WITHIN)              /* R15: the backup process gives control back */
}

inline begin_program() {
  alive = 1; stage = stage_listening; asked = 0; requests = 0; switches = 0; owed = 0; must_release = 0;
  since_entry = 0; since_request = SPACING; since_switch = SPACING; failsafe_state = failsafe_silent; failsafe_age = 0; fast = 0; order = 0;
  release_next = 0; unused = 0; answer = no_answer_yet; silent = HEARD_FOR + 1; seen_ours = 0; seen_virtual_rc = 0;
  lost = 0; since_obtain = SPACING; obtains = 0; dead_for = 0; rounds = 0; dead_held = 0
}

active proctype world() {
  do
  :: atomic {
     if  /* at most one unusual event */
     :: event = 0
     :: f -> event = 1
     :: f && ours -> event = 21
     :: !f -> event = 2
     :: !other -> event = 3
     :: other -> event = 4
     :: virtual_rc -> event = 5
     :: event = 6
     :: event = 7
     :: alive -> event = 8
     :: alive && stage != stage_ready && (hbit(ACQUIRING_STAGES | HOLDING_STAGES, stage) || asked) -> event = 9
     :: alive && stage == stage_in_control -> event = 10
     :: alive && (failsafe_state == failsafe_nominal || failsafe_state == failsafe_coast) -> event = 11
     :: alive && (failsafe_state == failsafe_nominal || failsafe_state == failsafe_coast) -> event = 12
     :: event = 13
     :: alive -> event = 14
     :: alive -> event = 15
     :: alive && (ours || virtual_rc) -> event = 16
     :: !alive && rounds == 0 -> event = 17
     :: alive && stage == stage_in_control -> event = 18
     :: alive && stage == stage_obtaining -> event = 19
     :: alive && order -> event = 20
     :: alive && failsafe_state == failsafe_level -> event = 22
     :: alive && (failsafe_state == failsafe_nominal || failsafe_state == failsafe_coast) -> event = 23
     :: alive && failsafe_state == failsafe_nominal -> event = 24
     :: alive && !task && (hbit(ACQUIRING_STAGES, stage) || stage == stage_in_control) -> event = 25
     :: task -> event = 26
     :: task -> event = 27
     :: alive && failsafe_state == failsafe_nominal -> event = 28
     :: alive && failsafe_state != failsafe_silent -> event = 29
     :: alive && failsafe_state != failsafe_silent -> event = 30
     fi;
     d_step {
     since_obtain = (since_obtain < SPACING -> since_obtain + 1 : SPACING);
     conditions = 0; failsafe_conditions = 0; push = 0; action = ACT_NONE; wants = 0;
     if
     :: event == 1 -> f = 0; lose()               /* the pilot turns the mode switch */
     :: event == 21 -> f = 0                      /* the same, but the autopilot keeps the program in control */
     :: event == 2 -> f = 1
     :: event == 3 -> lose(); other = 1           /* the mobile app takes control */
     :: event == 4 -> other = 0
     :: event == 5 -> virtual_rc = 0              /* the autopilot ends Virtual RC by itself */
     :: event == 6 -> line_in = !line_in
     :: event == 7 -> line_out = !line_out
     :: event == 8 -> conditions = A_ASKED; order = 1; lost = 0; obtains = (hbit(ACQUIRING_STAGES | HOLDING_STAGES, stage) -> obtains : 0)
     :: event == 9 -> order = 0; task = 0; failsafe_conditions = L_OPERATOR_RELEASES; release_next = release_next || failsafe_state == failsafe_silent
     :: event == 10 -> pose = !pose
     :: event == 11 -> failsafe_conditions = L_ESTIMATE_LOST
     :: event == 12 -> failsafe_conditions = L_UNSOUND
     :: event == 13 -> lose(); push = 0; conditions = A_RESTARTED    /* the autopilot restarts without a message */
     :: event == 14 -> conditions = A_PORT_BACK
     :: event == 15 -> conditions = A_OWN_STALL
     :: event == 16 -> alive = 0; dead_for = 0; rounds = ROUNDS; failsafe_state = failsafe_silent; fast = 0; stage = stage_silent; answer = no_answer_yet; lost = 0; order = 0; task = 0; release_next = 0; held = 0; blind = 0
     :: event == 17 -> begin_program()
     :: event == 18 -> conditions = A_NO_ANSWER
     :: event == 19 -> answer = no_answer_yet     /* the answer to the request is lost */
     :: event == 20 -> order = 0                  /* the order to fly expires */
     :: event == 22 -> fast = !fast               /* the aircraft becomes too fast for a handover, or slow enough again */
     :: event == 23 -> failsafe_conditions = L_OUTSIDE
     :: event == 24 -> failsafe_conditions = L_PLACE_LOST
     :: event == 25 -> task = 1                   /* the operator orders a take-off, or a landing */
     :: event == 26 -> task = 0; release_next = 1 /* the task has failed, or the aircraft has landed */
     :: event == 27 -> task = 0                   /* the aircraft has taken off: the course begins */
     :: event == 28 -> failsafe_conditions = L_SWINGS_ON
     :: event == 29 -> failsafe_conditions = L_ON_GROUND
     :: event == 30 -> failsafe_conditions = L_FAILURE
     :: else
     fi;
     if
     :: alive ->
        if
        :: line_in ->
           silent = 0; seen_f = f; seen_ours = ours; seen_virtual_rc = virtual_rc;
           conditions = conditions | (push -> A_LOST_PUSH : 0)
        :: else -> silent = (silent <= HEARD_FOR -> silent + 1 : silent); conditions = conditions & ~A_RESTARTED
        fi;
        lost = lost || (stage == stage_in_control && (silent > HEARD_FOR || !seen_f || !seen_ours || (VIRTUAL_RC && !seen_virtual_rc) ||
               (conditions & (A_LOST_PUSH | A_OWN_STALL | A_RESTARTED | A_PORT_BACK))));
        conditions = conditions | (release_next -> A_RELEASE_ASKED : 0);
        if
        :: stage == stage_asking_version || stage == stage_activating || stage == stage_setting_rates ->
           conditions = conditions | (WELL -> A_DONE : A_NO_ANSWER)
        :: stage == stage_obtaining && answer == is_done -> conditions = conditions | A_DONE
        :: stage == stage_obtaining && answer == is_again -> conditions = conditions | A_AGAIN
        :: stage == stage_obtaining && answer == is_refused -> conditions = conditions | A_REFUSED
        :: stage == stage_obtaining && answer == no_answer_yet -> conditions = conditions | A_NO_ANSWER
        :: else
        fi;
        answer = no_answer_yet;
        program_step();
        ladder_step()
     :: else ->
        dead_for = (dead_for < HANG_TIME -> dead_for + 1 : HANG_TIME - 1);
        if
        :: dead_for == HANG_TIME && rounds > 0 ->  /* a round is two releases, every second step */
           rounds--;
           if
           :: line_out -> receive_release(); receive_release()
           :: else
           fi;
           dead_for = HANG_TIME - 2
        :: else
        fi
     fi;
     examine();
     event = 0
     }
     }
  od
}
