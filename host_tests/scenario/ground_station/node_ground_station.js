// SPDX-License-Identifier: BSD-3-Clause
// A room that uses another implementation of MAVLink (node-mavlink). node_mavlink_test.cpp controls it line by line, so
// that it runs in the test's time. Usage: node node_ground_station.js NODE_MODULES PORT KEY_HEX FIRST_UNIX_MS
//   pose US X Y Z QW QX QY QZ   signs and sends ATT_POS_MOCAP through a network that loses, doubles and reorders
//   packets goal X Y Z                  sends SET_POSITION_TARGET_LOCAL_NED with only the position in use
//   order COMMAND PARAM1        sends COMMAND_LONG
//   lists                       sends MISSION_REQUEST_LIST, and MISSION_COUNT for an upload of two items
//   parameters                  sends PARAM_REQUEST_LIST
//   time MS                     sets the simulated time
//   state                       prints what was received, as one line of JSON
// Every line gets one line as an answer: "ok", or the JSON.
'use strict';
const [folder, port, keyHex, firstMs] = process.argv.slice(2);
const { createRequire } = require('module');
const path = require('path');
const load = createRequire(path.join(path.resolve(folder), 'none.js'));
const { MavLinkProtocolV2, MavLinkPacketSplitter, MavLinkPacketParser } = load('node-mavlink');
const { minimal, common } = load('mavlink-mappings');
const dgram = require('dgram');
const { PassThrough } = require('stream');

const key = Buffer.from(keyHex, 'hex');
const protocol = new MavLinkProtocolV2(9, 197, MavLinkProtocolV2.IFLAG_SIGNED);
const socket = dgram.createSocket('udp4');
const registry = { ...minimal.REGISTRY, ...common.REGISTRY };
const read = { frames: 0, wrong: 0, armed: false, position: null, attitudes: 0, answers: {}, text: '', battery: -1,
               items: null, uploaded: null, parameters: {} };
let number = 0;
let timeMs = Number(firstMs);
let lastMs = timeMs;
let held = null;
let seed = 12345;
function chance() {  // its own random generator, so that each flight is the same
  seed = (Math.imul(seed, 1103515245) + 12345) & 0x7fffffff;
  return seed / 0x7fffffff;
}

const bytes = new PassThrough();
bytes.pipe(new MavLinkPacketSplitter()).pipe(new MavLinkPacketParser()).on('data', (packet) => {
  read.frames += 1;
  if (!packet.signature || !packet.signature.matches(key)) {
    read.wrong += 1;
  }
  const type = registry[packet.header.msgid];
  if (!type) {
    return;
  }
  const message = packet.protocol.data(packet.payload, type);
  if (type === minimal.Heartbeat) {
    read.armed = (message.baseMode & 128) !== 0;
  } else if (type === common.LocalPositionNed) {
    read.position = [message.x, message.y, message.z];
  } else if (type === common.AttitudeQuaternion) {
    read.attitudes += 1;
  } else if (type === common.BatteryStatus) {
    read.battery = message.batteryRemaining;
  } else if (type === common.CommandAck) {
    read.answers[message.command] = message.result;
  } else if (type === common.StatusText) {
    read.text += message.text;
  } else if (type === common.MissionCount) {
    read.items = message.count;
  } else if (type === common.MissionAck) {
    read.uploaded = message.type;
  } else if (type === common.ParamValue) {
    read.parameters[message.paramId] = message.paramValue;
  }
});
socket.on('message', (packet) => bytes.write(packet));

function transmit(packet, done) {
  socket.send(packet, Number(port), '127.0.0.1', () => done());
}
function send(message, done) {
  lastMs = Math.max(lastMs + 1, Math.floor(timeMs));  // the time stamp of a signature must increase
  const packet = protocol.sign(protocol.serialize(message, number++ & 255), 3, key, lastMs);
  if (chance() < 0.05) {
    return done();
  }
  if (!held && chance() < 0.05) {
    held = packet;
    return done();
  }
  const late = held;
  held = null;
  const packets = chance() < 0.05 ? [packet, packet] : [packet];
  if (late) {
    packets.push(late);
  }
  const next = () => (packets.length > 0 ? transmit(packets.shift(), next) : done());
  next();
}

const commands = {
  pose(words, done) {
    const pose = new common.MotionCaptureAttPos();
    pose.timeUsec = BigInt(words[0]);
    [pose.x, pose.y, pose.z] = words.slice(1, 4).map(Number);
    pose.q = words.slice(4, 8).map(Number);
    pose.covariance = new Array(21).fill(0);
    send(pose, done);
  },
  goal(words, done) {
    const goal = new common.SetPositionTargetLocalNed();
    [goal.x, goal.y, goal.z] = words.map(Number);
    goal.typeMask = 0b110111111000;
    goal.coordinateFrame = 1;
    goal.targetSystem = 1;
    goal.targetComponent = 0;
    for (const field of ['timeBootMs', 'vx', 'vy', 'vz', 'afx', 'afy', 'afz', 'yaw', 'yawRate']) {
      goal[field] = 0;
    }
    send(goal, done);
  },
  order(words, done) {
    const order = new common.CommandLong();
    order.command = Number(words[0]);
    order._param1 = Number(words[1]);
    for (let i = 2; i <= 7; ++i) {
      order['_param' + i] = 0;
    }
    order.confirmation = 0;
    order.targetSystem = 1;
    order.targetComponent = 0;
    send(order, done);
  },
  lists(words, done) {
    const list = new common.MissionRequestList();
    [list.targetSystem, list.targetComponent, list.missionType] = [1, 0, 0];
    const count = new common.MissionCount();
    [count.count, count.targetSystem, count.targetComponent, count.missionType, count.opaqueId] = [2, 1, 0, 0, 0];
    send(list, () => send(count, done));
  },
  parameters(words, done) {
    const list = new common.ParamRequestList();
    [list.targetSystem, list.targetComponent] = [1, 0];
    send(list, done);
  },
  time(words, done) {
    timeMs = Number(firstMs) + Number(words[0]);
    done();
  },
};
socket.bind(0, '127.0.0.1', () => {
  const lines = require('readline').createInterface({ input: process.stdin });
  const say = (text) => process.stdout.write(text + '\n');
  lines.on('line', (line) => {
    const [word, ...words] = line.split(' ');
    if (word === 'state') {
      setImmediate(() => say(JSON.stringify(read)));
    } else {
      commands[word](words, () => say('ok'));
    }
  });
  lines.on('close', () => process.exit(0));
  say('ok');
});
