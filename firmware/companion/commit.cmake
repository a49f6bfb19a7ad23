# Writes a source with two texts where it would change: the version, and the commit of the checkout with its date. At every build, because a commit
# is made without touching a file.
# cmake -DSOURCE=... -DVERSION=... -DOUT=... -P commit.cmake
execute_process(COMMAND git -C ${SOURCE} rev-parse --short=10 HEAD OUTPUT_VARIABLE commit
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
execute_process(COMMAND git -C ${SOURCE} show --no-patch --format=%cs HEAD OUTPUT_VARIABLE date
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(commit AND date)
  string(APPEND commit " of ${date}")
endif()
execute_process(COMMAND git -C ${SOURCE} status --porcelain --untracked-files=no OUTPUT_VARIABLE changes ERROR_QUIET)
if(commit AND changes)
  string(APPEND commit " and changes")
endif()
file(CONFIGURE OUTPUT ${OUT} CONTENT "namespace m100::companion {
extern const char* const kVersionWords = \"${VERSION}\";
extern const char* const kCommitWords = \"${commit}\";
}  // namespace m100::companion
")
