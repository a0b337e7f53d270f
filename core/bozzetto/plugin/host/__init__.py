"""The host's side of the contract: manifests, loading, the registry."""
