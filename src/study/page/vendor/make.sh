#!/usr/bin/env bash
# Makes the one library of the page: the parts of three.js that it uses, in one file. Needs npm and its registry, and is
# needed only to change the version or the list of parts. Afterwards SHA256SUMS says what the files must be.
set -euo pipefail
cd "$(dirname "$0")"
here=$PWD
three=0.187.0
esbuild=0.28.2

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y > npm.log
npm install --ignore-scripts --no-audit --no-fund "three@$three" "esbuild@$esbuild" >> npm.log

cat > parts.js <<'PARTS'
export {
  BufferAttribute, BufferGeometry, Color, ConeGeometry, CylinderGeometry, DirectionalLight, DoubleSide, FrontSide, Group,
  HemisphereLight, InstancedMesh, Matrix4, Mesh, MeshLambertMaterial, OrthographicCamera, Quaternion, Scene, SphereGeometry,
  Vector3, WebGLRenderer,
} from "three";
PARTS
node_modules/.bin/esbuild parts.js --bundle --minify --format=iife --global-name=THREE --target=es2022 --charset=ascii \
  --legal-comments=inline --log-level=error --outfile="$here/three-$three.min.js"
cp node_modules/three/LICENSE "$here/LICENSE"
cd "$here"
sha256sum LICENSE "three-$three.min.js" > SHA256SUMS
ls -l "three-$three.min.js"
