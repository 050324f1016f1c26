#!/bin/sh
# Makes the tables of reference systems, or the table of PROJ's places that they are tested against, with PROJ in an
# environment of its own:
#
#     tools/crs/run.sh tables
#     tools/crs/run.sh truth FILE [POINTS] [--texts]
set -eu
here=$(cd "$(dirname "$0")" && pwd)
environment=${HEDGEHOP_CRS_VENV:-"$here/../../target/crs-venv"}
what=${1:?tables or truth}
shift
if [ ! -x "$environment/bin/python" ]; then
    python3 -m venv "$environment"
    "$environment/bin/pip" install --quiet -r "$here/requirements.txt"
fi
exec "$environment/bin/python" "$here/$what.py" "$@"
