# Completion for m100: asks the program itself, so it knows what that program knows.
_m100() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[1]}
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W "$(m100 --help 2>/dev/null | sed -n '/^Subcommands:/,$s/^  \([a-z][a-z-]*\)  *.*/\1/p') --help --version" -- "$word"))
  elif [[ $word == -* ]]; then
    COMPREPLY=($(compgen -W "$(m100 "$command" --help 2>/dev/null | grep -o -- '--[a-z0-9-]*' | sort -u)" -- "$word"))
  elif [[ $before == --port || $before == --pose-port ]]; then
    COMPREPLY=($(compgen -G "/dev/tty[AU]*"; compgen -G "/dev/m100-*"))
  else
    COMPREPLY=($(compgen -f -- "$word"))
  fi
}
complete -o filenames -F _m100 m100
