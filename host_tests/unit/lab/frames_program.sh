#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
# Tests `m100-lab frames` as a user runs it: bytes to lines to bytes, statistics last, one line of message and exit code
# 2 for bad input.
set -u
lab=$1
space=$(mktemp -d)
trap 'rm -rf "$space"' EXIT
failures=0
fail() { echo "FAILED: $1"; failures=$((failures + 1)); }

line='{"session":2,"is_ack":false,"seq":7,"encrypted":false,"cmd_set":1,"cmd_id":0,"payload_hex":"01"}'
hex=$("$lab" frames encode <<< "$line") || fail "encode"
[[ $hex == aa13000200000000* ]] || fail "a frame of 19 bytes, not $hex"
printf '\xAA\x00noise' > "$space/bytes"
printf '%b' "$(sed 's/../\\x&/g' <<< "$hex")" >> "$space/bytes"
"$lab" frames decode "$space/bytes" > "$space/lines" || fail "decode"
grep -q '"offset":7,"session":2.*"name":"obtain_control","fields":{"request":1}' "$space/lines" || fail "the frame's line"
tail -n 1 "$space/lines" | grep -q '"statistics":{"frames":1,"crc16_errors":1,"crc32_errors":0,"resyncs":1,"bytes_dropped":7' \
  || fail "the statistics"
[[ $("$lab" frames encode "$space/lines") == "$hex" ]] || fail "what was decoded is not encoded again"
[[ $("$lab" frames decode < /dev/null | wc -l) == 1 ]] || fail "nothing in, statistics out"

bad() {  # text on stderr, arguments
  local expected=$1
  shift
  "$lab" "$@" > "$space/out" 2> "$space/err"
  local code=$?
  [[ $code == 2 && $(wc -l < "$space/err") == 1 ]] && grep -qF -- "$expected" "$space/err" \
    || fail "$* gave $code: $(cat "$space/err")"
}
echo "not json" > "$space/bad"
bad "bad:1: is not a JSON object" frames encode "$space/bad"
echo '{"session":99}' > "$space/bad"
bad "bad:1: 'session': must be 0 to 31" frames encode "$space/bad"
bad "cannot be read" frames decode "$space/nowhere"
bad "--key" frames decode --key "$(printf 'a%.0s' {1..64})" "$space/bytes"
touch "$space/key" && chmod 600 "$space/key"
echo 12 > "$space/key"
bad "key:1: the key needs 64 hexadecimal digits" frames decode --key-file "$space/key" "$space/bytes"
printf 'a%.0s' {1..64} > "$space/key"
secret='{"session":2,"is_ack":false,"seq":7,"encrypted":true,"cmd_set":1,"cmd_id":0,"payload_hex":"01"}'
"$lab" frames encode --key-file "$space/key" <<< "$secret" | sed 's/../\\x&/g' > "$space/escaped"
printf '%b' "$(cat "$space/escaped")" > "$space/secret"
"$lab" frames decode --key-file "$space/key" "$space/secret" | grep -q '"name":"obtain_control"' || fail "decoded with the key"
"$lab" frames decode "$space/secret" | grep -q '"name":"obtain_control"' && fail "read without the key"
for program in encode decode; do
  chmod 640 "$space/key"
  bad "holds a key that others can read" frames $program --key-file "$space/key" "$space/bytes"
done
bad "cannot be read" frames encode --key-file "$space/nowhere" "$space/bytes"
bad "subcommand" frames
exit $((failures > 0))
