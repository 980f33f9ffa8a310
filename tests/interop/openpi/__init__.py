"""openpi's own client drives against our policy server: `./dev interop openpi`."""
