"""A keystore of SROS2, made with openssl alone: authorities, and enclaves that they know."""

from __future__ import annotations

import subprocess
from pathlib import Path

GOVERNANCE = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
  xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules><domain_rule>
    <domains><id_range><min>0</min><max>230</max></id_range></domains>
    <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
    <enable_join_access_control>true</enable_join_access_control>
    <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
    <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
    <rtps_protection_kind>SIGN</rtps_protection_kind>
    <topic_access_rules><topic_rule>
      <topic_expression>*</topic_expression>
      <enable_discovery_protection>true</enable_discovery_protection>
      <enable_liveliness_protection>true</enable_liveliness_protection>
      <enable_read_access_control>true</enable_read_access_control>
      <enable_write_access_control>true</enable_write_access_control>
      <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
      <data_protection_kind>ENCRYPT</data_protection_kind>
    </topic_rule></topic_access_rules>
  </domain_rule></domain_access_rules>
</dds>
"""
PERMISSIONS = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
  xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions><grant name="of_{name}">
    <subject_name>CN={subject}</subject_name>
    <validity><not_before>2020-01-01T00:00:00</not_before><not_after>2040-01-01T00:00:00</not_after></validity>
    <allow_rule>
      <domains><id_range><min>0</min><max>230</max></id_range></domains>
      <publish><topics>{topics}</topics></publish>
      <subscribe><topics>{topics}</topics></subscribe>
    </allow_rule>
    <default>DENY</default>
  </grant></permissions>
</dds>
"""
TOPICS = ("rt/*", "rq/*", "rr/*", "ros_discovery_info")


def openssl(*arguments: object) -> None:
    subprocess.run(["openssl", *map(str, arguments)], check=True, capture_output=True)


class Keystore:
    """In a folder, with authorities of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.authority = folder / "private"
        self.authority.mkdir(parents=True)
        for name in ("identity_ca", "permissions_ca"):
            self._make_key(self.authority / f"{name}.key.pem")
            openssl(
                *("req", "-x509", "-new", "-key", self.authority / f"{name}.key.pem", "-sha256", "-days", 3650),
                *("-subj", f"/CN={name}", "-out", self.authority / f"{name}.cert.pem"),
            )

    def add(self, name: str, *, subject: str = "", topics: tuple[str, ...] = TOPICS, days: int = 365) -> Path:
        """An enclave; `subject` is what its certificate names, the enclave's own name by default."""
        folder = self.folder / "enclaves" / name
        folder.mkdir(parents=True)
        subject = subject or name
        self._make_key(folder / "key.pem")
        request = folder / "request.pem"
        openssl("req", "-new", "-key", folder / "key.pem", "-subj", f"/CN={subject}", "-out", request)
        authority = self.authority / "identity_ca"
        openssl(
            *("x509", "-req", "-in", request, "-CA", f"{authority}.cert.pem", "-CAkey", f"{authority}.key.pem"),
            *("-CAcreateserial", "-sha256", "-days", days, "-out", folder / "cert.pem"),
        )
        for authority_name in ("identity_ca", "permissions_ca"):
            certificate = (self.authority / f"{authority_name}.cert.pem").read_text()
            (folder / f"{authority_name}.cert.pem").write_text(certificate)
        allowed = "".join(f"<topic>{topic}</topic>" for topic in topics)
        self._sign(folder / "governance.p7s", GOVERNANCE)
        self._sign(folder / "permissions.p7s", PERMISSIONS.format(name=name, subject=subject, topics=allowed))
        return folder

    @staticmethod
    def _make_key(file: Path) -> None:
        openssl("ecparam", "-name", "prime256v1", "-genkey", "-noout", "-out", file)

    def _sign(self, file: Path, text: str) -> None:
        plain = file.with_suffix(".xml")
        plain.write_text(text)
        authority = self.authority / "permissions_ca"
        openssl(
            *("smime", "-sign", "-text", "-in", plain, "-out", file),
            *("-signer", f"{authority}.cert.pem", "-inkey", f"{authority}.key.pem"),
        )
