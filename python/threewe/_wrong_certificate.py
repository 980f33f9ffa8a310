"""Certificate that no client may trust: self-signed, and its key is public. A scripted server shows it as a fault."""

from __future__ import annotations

import ssl
import tempfile
from pathlib import Path

PEM = """\
-----BEGIN PRIVATE KEY-----
MIGHAgEAMBMGByqGSM49AgEGCCqGSM49AwEHBG0wawIBAQQgFcqIwmvIqdqt3qhf
Zk9AUNgcfmH91a2wMmloEiGRLSuhRANCAAT6YN4vY/123NWXTeVAVxP4/kdwRglU
2Q9RnTDgoAigFSL/vmT6pwO3ag0eX3f7TtktaPjCrTt5YmMVniapKn04
-----END PRIVATE KEY-----
-----BEGIN CERTIFICATE-----
MIIBijCCATGgAwIBAgIUR82TlLo1xKIWCx9MxeFYtUKvsb0wCgYIKoZIzj0EAwIw
GjEYMBYGA1UEAwwPdGhyZWV3ZS50ZXN0aW5nMCAXDTI2MTEyNTE0NTMzNFoYDzIx
MjYxMTAxMTQ1MzM0WjAaMRgwFgYDVQQDDA90aHJlZXdlLnRlc3RpbmcwWTATBgcq
hkjOPQIBBggqhkjOPQMBBwNCAAT6YN4vY/123NWXTeVAVxP4/kdwRglU2Q9RnTDg
oAigFSL/vmT6pwO3ag0eX3f7TtktaPjCrTt5YmMVniapKn04o1MwUTAdBgNVHQ4E
FgQUTYTVbyzKdTz6M0DqIZ/Dl+iCGF4wHwYDVR0jBBgwFoAUTYTVbyzKdTz6M0Dq
IZ/Dl+iCGF4wDwYDVR0TAQH/BAUwAwEB/zAKBggqhkjOPQQDAgNHADBEAiBxYGog
jH1qXX/InbqZHjLwccGVBX0skMdnPtYQEmHfRgIgZllfsWZB5zoUSI28zWYJfW3r
9Eyl+yIrftSfrhKQ5sw=
-----END CERTIFICATE-----
"""


def wrong_context() -> ssl.SSLContext:
    """Of a server with that certificate."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "wrong.pem")
        file.write_text(PEM, encoding="utf-8")
        context.load_cert_chain(file)
    return context
