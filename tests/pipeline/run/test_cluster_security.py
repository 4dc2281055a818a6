"""A scheduler that asks for certificates: who has them computes, who has not gets one line that names the setting."""

import datetime

import dask
import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from pipeline import store
from pipeline.__main__ import main
from tests.pipeline.planes import assert_same_contents, contents
from tests.pipeline.schedulers import Scheduler

PLANE = ["plane=omega_fe", "plane.sweep.num=21", "plane.parameter.num=6", "stages=[sweep]"]


class Authority:
    """Makes certificates in a folder."""

    def __init__(self, folder):
        folder.mkdir()
        self.folder, self._key = folder, ec.generate_private_key(ec.SECP256R1())
        self.name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, folder.name)])
        self.file = self._write("ca", self._sign(self.name, self._key.public_key(), True))

    def certificate(self, name, passphrase=None):
        """A certificate and its key, as files."""
        key = ec.generate_private_key(ec.SECP256R1())
        subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
        locked = serialization.BestAvailableEncryption(passphrase) if passphrase else serialization.NoEncryption()
        text = key.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, locked)
        certificate = self._sign(subject, key.public_key(), False)
        return self._write(f"{name}-cert", certificate), self._write(f"{name}-key", text)

    def _sign(self, subject, public_key, authority):
        now = datetime.datetime.now(datetime.UTC)
        builder = x509.CertificateBuilder(self.name, subject, public_key, x509.random_serial_number())
        builder = builder.not_valid_before(now - datetime.timedelta(days=1))
        builder = builder.not_valid_after(now + datetime.timedelta(days=1))
        builder = builder.add_extension(x509.BasicConstraints(ca=authority, path_length=None), critical=True)
        return builder.sign(self._key, hashes.SHA256()).public_bytes(serialization.Encoding.PEM)

    def _write(self, name, text):
        file = self.folder / f"{name}.pem"
        file.write_bytes(text)
        return file


def settings(authority, certificate, **changes):
    cert, key = certificate
    values = {"ca_file": authority.file, "cert": cert, "key": key, **changes}
    return [f"cluster.security.{name}={value}" for name, value in values.items() if value is not None]


@pytest.fixture(scope="module")
def authority(tmp_path_factory):
    return Authority(tmp_path_factory.mktemp("keys") / "ours")


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory, authority):
    cert, key = authority.certificate("cluster")
    options = ["--protocol", "tls", "--tls-ca-file", authority.file, "--tls-cert", cert, "--tls-key", key]
    with Scheduler(tmp_path_factory.mktemp("tls"), *map(str, options)) as started:
        started.add_worker()
        yield started


@pytest.mark.costly
def test_a_scheduler_at_a_tls_address_computes_for_who_has_a_certificate(tmp_path, authority, scheduler):
    assert scheduler.address.startswith("tls://")
    here = [*PLANE, "cluster=none", f"output.root={tmp_path / 'here'}"]
    there = [*PLANE, "cluster=scheduler", f"cluster.scheduler_file={scheduler.file}", "cluster.timeout=60"]
    certificate = authority.certificate("client")
    assert main(here) == 0
    assert main([*there, f"output.root={tmp_path / 'there'}", *settings(authority, certificate)]) == 0
    # What dask's own configuration says is used too.
    tls = {"ca-file": authority.file, "client.cert": certificate[0], "client.key": certificate[1]}
    with dask.config.set({f"distributed.comm.tls.{key}": str(file) for key, file in tls.items()}):
        assert main([*there, f"output.root={tmp_path / 'again'}"]) == 0
    for folder in ("there", "again"):
        path = tmp_path / folder / "store/omega_fe.zarr"
        assert (store.statuses(path) == store.COMPLETE).all()
        assert_same_contents(contents(path), contents(tmp_path / "here/store/omega_fe.zarr"))


def refused(words, tmp_path, capsys, key):
    """Assert that a run ends with one line that names the key, and writes nothing."""
    assert main([*PLANE, "cluster=scheduler", "cluster.timeout=2", f"output.root={tmp_path / 'outputs'}", *words]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and said.startswith("error: ") and f"{key} = " in said, said
    assert not (tmp_path / "outputs").exists()
    return said


def test_whoever_has_no_certificate_of_that_authority_is_refused(tmp_path, authority, scheduler, capsys):
    address, good = f"cluster.address={scheduler.address}", authority.certificate("client")
    stranger = Authority(tmp_path / "theirs")
    theirs = stranger.certificate("client")
    refused([address], tmp_path, capsys, "cluster.security.ca_file")
    refused([address, *settings(stranger, theirs)], tmp_path, capsys, "cluster.security.ca_file")
    # Either side may be the one that does not believe the other.
    refused([address, *settings(authority, good, ca_file=stranger.file)], tmp_path, capsys, "cluster.security.ca_file")
    refused([address, *settings(authority, theirs)], tmp_path, capsys, "cluster.security.cert")


@pytest.mark.costly
def test_an_address_of_the_other_transport_is_told(tmp_path, authority, scheduler, capsys):
    plain = f"cluster.address={scheduler.address.replace('tls', 'tcp')}"
    assert f"it may be one at {scheduler.address}" in refused([plain], tmp_path, capsys, "cluster.address")
    (tmp_path / "plain").mkdir()
    with Scheduler(tmp_path / "plain") as other:
        words = [f"cluster.address={other.address.replace('tcp', 'tls')}"]
        words += settings(authority, authority.certificate("client"))
        assert f"it may be one at {other.address}" in refused(words, tmp_path, capsys, "cluster.address")


def test_files_that_cannot_be_used_are_named(tmp_path, authority, capsys):
    address, good = "cluster.address=tls://127.0.0.1:9", authority.certificate("client")
    other, locked = authority.certificate("other"), authority.certificate("locked", b"secret")
    text = tmp_path / "text.pem"
    text.write_text("not a key")

    def said(key, certificate=good, address=address, **changes):
        refused([address, *settings(authority, certificate, **changes)], tmp_path, capsys, key)

    said("cluster.security.ca_file", ca_file=tmp_path / "nowhere")
    said("cluster.security.cert", cert=tmp_path)
    said("cluster.security.key", locked)
    said("cluster.security.cert", cert=None)
    said("cluster.security", (good[0], other[1]))
    said("cluster.security", cert=text)
    said("cluster.security", ca_file=text)
    said("cluster.security.ca_file", address="cluster.address=tcp://127.0.0.1:9")
