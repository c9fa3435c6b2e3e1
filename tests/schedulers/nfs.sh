#!/bin/bash
# Workers on virtual machines that share a folder over NFS: with the locks of version 4.2, and with version 3 without locks, where
# each machine sees its own locks only. Clocks are wrong, and one machine is lost.
#
#   cargo build --release && sudo bash tests/schedulers/nfs.sh
#
# Needs root and the packages qemu-system-x86, busybox-static, kmod, cpio, rpcbind, nfs-ganesha and nfs-ganesha-vfs. The kernel
# of the machines is that of LINUX, a folder with an unpacked package of a Linux kernel (boot and lib/modules); without it, the
# package linux-image-cloud-amd64 is fetched. Results must be the bytes of one process.
set -eu
PATH=$PATH:/usr/sbin:/sbin
root=$(cd "$(dirname "$0")/../.." && pwd)
program=${LANDSCAPE:-$root/target/release/landscape}
work=$(mktemp -d)
cleanup() {
    cd /
    kill $(jobs -p) 2> /dev/null || true
    [ -e "$work/ganesha.pid" ] && kill "$(cat "$work/ganesha.pid")"
    rm -rf "$work"
}
trap cleanup EXIT
task="synth --object bottle_round -n 12 --seed 1 --drop 0 -q"

# The kernel, and a file system in memory with the program.
linux=${LINUX:-}
if [ -z "$linux" ]; then
    linux=$work/linux
    (cd "$work" && apt-get download -qq "$(apt-cache depends linux-image-cloud-amd64 | awk '/Depends: linux-image/ { print $2 }')" &&
        dpkg -x linux-image-*.deb "$linux")
fi
release=$(basename "$linux"/lib/modules/*)
guest=$work/guest
mkdir -p "$guest"/{bin,dev,proc,sys,tmp,shared,lib/modules}
cp -r "$linux/lib/modules/$release" "$guest/lib/modules"
depmod -b "$guest" "$release"
cp "$(command -v busybox)" "$guest/bin/busybox"
cp "$program" "$guest/bin/landscape"
# The libraries of the program, none if it is static.
for library in $(ldd "$program" | grep -o '/[^ ]*'); do cp -L --parents "$library" "$guest"; done
cat > "$guest/init" <<'EOF'
#!/bin/busybox sh
/bin/busybox mkdir -p /usr/bin /sbin
/bin/busybox --install -s /bin
export PATH=/bin:/sbin
mount -t proc none /proc
mount -t sysfs none /sys
mount -t devtmpfs none /dev
for word in $(cat /proc/cmdline); do case $word in machine=*) hostname "${word#machine=}" ;; mount=*) options=${word#mount=} ;; esac; done
for module in virtio_pci virtio_net nfs nfsv3 nfsv4; do modprobe $module; done
ip link set lo up
ip link set eth0 up
ip address add 10.0.2.15/24 dev eth0
ip route add default via 10.0.2.2
if mount -t nfs -o "addr=10.0.2.2,port=2049,$options" 10.0.2.2:/shared /shared; then
    cd /shared
    sh "./$(hostname).sh"
    echo $? > "$(hostname).code"
    cd /
    umount /shared
fi
poweroff -f
EOF
chmod +x "$guest/init"
(cd "$guest" && find . | cpio -o -H newc --quiet | gzip -1) > "$work/guest.gz"

# machine NAME CLOCK OPTIONS ARGUMENTS...: becomes a machine of this name, whose clock shows CLOCK and which mounts the folder
# with OPTIONS, and runs the program there.
machine() {
    local name=$1 clock=$2 options=$3
    shift 3
    rm -f "$served/$name.code"
    echo "exec landscape $* 2> $name.said" > "$served/$name.sh"
    exec qemu-system-x86_64 -accel tcg -cpu max -m 512 -nographic -no-reboot -nodefaults \
        -serial "file:$work/$name.console" -netdev user,id=net -device virtio-net-pci,netdev=net -rtc "base=$clock" \
        -kernel "$linux/boot/vmlinuz-$release" -initrd "$work/guest.gz" \
        -append "console=ttyS0 panic=-1 quiet machine=$name mount=$options"
}

# ended NAME: waits for the machine, which must have ended well.
ended() {
    wait "$1"
    [ "$(cat "$served/$2.code")" = 0 ] || { cat "$work/$2.console" "$served/$2.said" >&2; exit 1; }
}

# share OPTIONS: three workers, of which north is lost while it works; another machine joins what the workers have left.
share() {
    local options=$1
    machine east "$(date -u -d '+3 hours' +%FT%T)" "$options" $task --threads 1 --worker 1/3 -o g.parquet &
    local east=$!
    machine west "$(date -u -d '-2 hours' +%FT%T)" "$options" $task --threads 1 --worker 2/3 -o g.parquet &
    local west=$!
    machine north "$(date -u +%FT%T)" "$options" $task --threads 1 --worker 3/3 -o g.parquet &
    local north=$!
    until [ "$(stat -c %s "$served"/g.parquet.workers/3-of-3*.journal 2> /dev/null || echo 0)" -gt 1000 ]; do
        kill -0 "$north" || { cat "$work/north.console" "$served/north.said" >&2; exit 1; }
        sleep 0.05
    done
    kill -9 "$north"
    wait "$north" || true
    ended "$east" east
    ended "$west" west
    machine south "$(date -u -d '+1 day' +%FT%T)" "$options" $task -o g.parquet &
    ended $! south
    cmp "$served/g.parquet" "$work/one/g.parquet"
}

mkdir "$work/one" "$work/served"
served=$work/served
(cd "$work/one" && "$program" $task -o g.parquet)
rpcinfo > /dev/null 2>&1 || rpcbind
cat > "$work/ganesha.conf" <<EOF
NFS_CORE_PARAM { Protocols = 3, 4; Bind_addr = 127.0.0.1; Enable_RQUOTA = false; Mount_Path_Pseudo = true; }
NFSv4 { Graceless = true; RecoveryRoot = $work/recovery; }
EXPORT {
    Export_Id = 1; Path = $served; Pseudo = /shared; Tag = shared; Access_Type = RW; Squash = No_Root_Squash; Protocols = 3, 4;
    SecType = sys; Transports = TCP; FSAL { Name = VFS; }
}
EOF
if (echo > /dev/tcp/127.0.0.1/2049) 2> /dev/null; then echo 'nfs: another server has port 2049' >&2; exit 1; fi
mkdir -p "$work/recovery" /run/ganesha
ganesha.nfsd -f "$work/ganesha.conf" -L "$work/ganesha.log" -p "$work/ganesha.pid" -N EVENT
for ((tries = 0; tries < 100; tries++)); do (echo > /dev/tcp/127.0.0.1/2049) 2> /dev/null && break; sleep 0.2; done

share vers=4.2,clientaddr=10.0.2.15
echo 'nfs: version 4.2: the same bytes'
rm -r "$served"/*
share vers=3,nolock,proto=tcp,mountproto=tcp,mountaddr=10.0.2.2
echo 'nfs: version 3 without locks: the same bytes'
