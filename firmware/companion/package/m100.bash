# Completion for m100 and m100-lab: asks the program itself, so it knows what that program knows.
_m100() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} program=${COMP_WORDS[0]} help words first=()
  while [ "$((${#first[@]} + 1))" -lt "$COMP_CWORD" ] && [[ ${COMP_WORDS[${#first[@]} + 1]} != -* ]]; do
    first+=("${COMP_WORDS[${#first[@]} + 1]}")
  done
  help=$("$program" "${first[@]}" --help 2>/dev/null)
  words=$(sed -nE "s/^  (-.,)?$before [A-Z]+:\{([^}]*)\}.*/\2/p" <<<"$help")
  if [[ $word == -* ]]; then
    COMPREPLY=($(compgen -W "$(grep -o -- '--[a-z0-9-]*' <<<"$help" | sort -u)" -- "$word"))
  elif [[ $help == *Subcommands:* ]]; then
    COMPREPLY=($(compgen -W "$(sed -n '/^Subcommands:/,$s/^  \([a-z][a-z-]*\)  *.*/\1/p' <<<"$help") --help" -- "$word"))
  elif [ -n "$words" ]; then
    COMPREPLY=($(compgen -W "${words//,/ }" -- "$word"))
  elif [[ $before == --port || $before == --pose-port ]]; then
    COMPREPLY=($(compgen -G "/dev/tty[AU]*"; compgen -G "/dev/m100-*"))
  else
    COMPREPLY=($(compgen -f -- "$word"))
  fi
}
complete -o filenames -F _m100 m100 m100-lab
